"""Junctions as a parameter of the structure varies."""
from __future__ import annotations

from ._library import InputError, check, copy_of, ffi, lib, pointer, text_of
import numpy as np

from ._atlas import Junction
from ._running import Bar, Job
from ._show import lines, table, text_table
from ._study import Study

_HEADING = ["point", "value", "energy", "frequency", "mark", "what"]


class Locus:
    """A junction as a parameter of the structure varies, in order from one end to the other.

    Attributes
    ----------
    junction : Junction
    parameter : str
    value : array [k]
        Of the parameter.
    energy : array [k], scaled by the clearance that the first contact has there
    frequency : array [k], rad/s, of the orbit
    length : array [k]
        That clearance.
    residual : array [k], relative
    mark : list of str
        start, the junction of the atlas; asked; fold, the parameter turns; meets, it is another kind of junction, too; end; ""
        elsewhere.
    what : list of str
        What is met, or why it ends.
    state : array [k, 2 n_dof]
        x, then v (1/s), scaled, as that of a junction.
    flights : array [k, max(letters, 1)], s
    """

    def __init__(self, junction: Junction, parameter: str, handle):
        k, n, letters = lib.ric_locus_n_point(handle), junction.atlas.model.n_dof, max(1, junction.letters)
        self.junction, self.parameter, self.mark, self.what = junction, parameter, [], []
        names = ("value", "energy", "frequency", "length", "residual")
        numbers, raw = np.zeros((len(names), k)), ffi.new("ric_locus_point *")
        self.state, self.flights = np.zeros((k, 2 * n)), np.zeros((k, letters))
        for i in range(k):
            check(lib.ric_locus_point_at(handle, i, raw))
            numbers[:, i] = [getattr(raw, name) for name in names]
            self.mark.append(text_of(lib.ric_locus_mark_text(raw.mark)))
            self.what.append(text_of(raw.what))
            self.state[i], self.flights[i] = copy_of(raw.state, 2 * n), copy_of(raw.flights, letters)
        self.value, self.energy, self.frequency, self.length, self.residual = numbers

    def __len__(self) -> int:
        return len(self.value)

    def marked(self, mark: str) -> np.ndarray:
        """Indices of the points with a mark: "fold", "asked", ..."""
        return np.flatnonzero(np.array(self.mark) == mark)

    def _rows(self) -> list:
        kept = [i for i in range(len(self)) if self.mark[i]]
        return [[i, float(self.value[i]), float(self.energy[i]), float(self.frequency[i]), self.mark[i], self.what[i]]
                for i in kept]

    def _head(self) -> str:
        low, high = (float(f(self.value)) for f in (np.min, np.max)) if len(self) else (np.nan, np.nan)
        return (f"Locus of {self.junction.title} along {self.parameter}: {len(self)} points, {self.parameter} from {low:.6g} to "
                f"{high:.6g}, {len(self.marked('fold'))} folds")

    def __repr__(self) -> str:
        return self._head() + ("\n" + text_table(_HEADING, self._rows()) if len(self) else "")

    def _repr_html_(self) -> str:
        return table(_HEADING, self._rows(), self._head()) + (lines(self.value, [self.energy]) if len(self) else "")


def _given(atlas, vary):
    """The section vary that counts, in a structure of the library, and what it borrows."""
    raw = ffi.new("ric_vary *")
    source = atlas.study if vary is None else vary
    if not isinstance(source, Study):
        source = Study(atlas.model, vary=dict(source))
    if not lib.ric_model_same(source.model._handle, atlas.model._handle):
        raise InputError("the study is one of another structure than that of the atlas")
    if not lib.ric_study_vary(source._handle, raw):
        raise InputError("there is no section vary, which says what the parameter changes; give for example "
                         'vary={"name": "k2", "at": 1, "from": 0.5, "to": 2, "stiffness": [[1, -1], [-1, 1]]}')
    return raw, source


def locus(atlas, junction, values, max_step: float, vary, progress) -> Locus:
    """As the command `locus` does it. What was found before Ctrl-C is lost with it."""
    at = junction if isinstance(junction, Junction) else atlas.junction(junction)
    raw, source = _given(atlas, vary)
    options, made, now = ffi.new("ric_locus_options *"), ffi.new("ric_locus **"), [0, 0.0]
    asked = np.ascontiguousarray(values, float).ravel()
    lib.ric_locus_options_init(options)
    options.n_value, options.values, options.max_step = asked.size, pointer(asked) if asked.size else ffi.NULL, max_step

    def call(job: Job) -> int:
        def told(points, value, user):
            now[:] = points, value
            return job.stopping
        options.progress = job.told = ffi.callback("bool(int, double, void *)", told, error=True)
        return lib.ric_locus_follow(atlas._handle, raw, at.id, options, made)

    bar, name = Bar(progress), text_of(raw.name)
    try:
        Job(call).run(lambda: bar.show(0, f"{now[0]} points, {name} = {now[1]:.6g}"))
        return Locus(at, name, made[0])
    finally:
        bar.close()
        lib.ric_locus_free(made[0])
        del source
