"""What takes long: in a thread of its own, so that Ctrl-C and a progress bar work while the library computes."""
from __future__ import annotations

import html
import sys
import threading
import time

from ._library import check, detail, error_of, lib

EVERY = 0.1  # s between two looks at how far it is


class Bar:
    """A progress bar on a terminal or in a notebook; nothing where neither is."""

    def __init__(self, wanted):
        self.notebook = wanted is not False and _in_notebook()
        self.terminal = wanted is not False and not self.notebook and (wanted is True or sys.stderr.isatty())
        self.handle, self.width, self.shown = None, 0, 0.0

    def show(self, part: float, text: str) -> None:
        """`part` of the way, 0 to 1, and what there is so far."""
        if time.monotonic() - self.shown < EVERY:
            return
        self.shown = time.monotonic()
        if self.terminal:
            filled = int(24 * part)
            sys.stderr.write(f"\r\033[K[{'#' * filled}{'.' * (24 - filled)}] {text}")
            sys.stderr.flush()
        elif self.notebook:
            self._display(f'<progress value="{part:.4f}" max="1" style="vertical-align: middle"></progress> '
                          f"{html.escape(text)}")

    def _display(self, markup: str) -> None:
        from IPython.display import HTML, display
        if self.handle is None:
            self.handle = display(HTML(markup), display_id=True)
        else:
            self.handle.update(HTML(markup))

    def close(self, text: str = "") -> None:
        """The end; `text` stays in a notebook."""
        if self.terminal:
            sys.stderr.write("\r\033[K")
            sys.stderr.flush()
        elif self.handle is not None:
            self._display(html.escape(text))


def _in_notebook() -> bool:
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return type(shell).__name__ == "ZMQInteractiveShell"


class Job:
    """A call of the library that can be stopped: the call asks `stopping`, which its progress function returns."""

    def __init__(self, call):
        self.call, self.stopping, self.failure = call, False, None
        self.ended = threading.Event()
        self.status, self.detail = lib.RIC_OK, ""

    def _work(self) -> None:
        try:
            self.status = self.call(self)
            self.detail = detail() if self.status != lib.RIC_OK else ""
        except BaseException as failure:  # told in the thread that waits
            self.failure = failure
        self.ended.set()

    def run(self, look) -> None:
        """Until it has ended; `look()` is called again and again. Raises what it or the call has raised, or Ctrl-C."""
        raised = None
        threading.Thread(target=self._work, name="ricochet", daemon=True).start()
        while not self.ended.is_set():  # a join that Ctrl-C breaks off may take the thread for ended
            try:
                self.ended.wait(EVERY / 2)
                if raised is None:
                    look()
            except BaseException as failure:  # KeyboardInterrupt too: what was done is written before it is raised
                raised, self.stopping = raised or failure, True
        if raised or self.failure:
            raise raised or self.failure
        if self.status != lib.RIC_OK:
            raise error_of(self.status, self.detail)


def in_parallel(calls, workers: int, look) -> list:
    """The results of `calls`, in their order; `look(how many are done)` is called again and again."""
    results, done, lock = [None] * len(calls), [0], threading.Lock()
    waiting = iter(range(len(calls)))

    def work(job):
        while not job.stopping:
            with lock:
                i = next(waiting, None)
            if i is None:
                break
            results[i] = calls[i]()
            with lock:
                done[0] += 1
        return lib.RIC_OK

    def all_of_them(job):
        helpers = [threading.Thread(target=helper._work, daemon=True) for helper in jobs[1:]]
        for helper in helpers:
            helper.start()
        status = work(job)
        for helper in helpers:
            helper.join()
        for helper in jobs[1:]:
            if helper.failure:
                raise helper.failure
        return status

    first = Job(all_of_them)
    jobs = [first] + [Job(lambda job: work(first)) for _ in range(max(1, workers) - 1)]
    first.run(lambda: look(done[0]))
    return results


def with_bar(calls, workers: int, progress, doing: str = "") -> list:
    """The same with a progress bar: how many of them are done, and what is done to them."""
    bar = Bar(progress)
    try:
        return in_parallel(calls, workers, lambda done: bar.show(done / max(1, len(calls)), f"{done} of {len(calls)}{doing}"))
    finally:
        bar.close()


__all__ = ["Bar", "Job", "check", "in_parallel", "with_bar"]
