#!/usr/bin/env python3
"""Hostile requests to the server of `ricochet view`, with nothing but the standard library.

    tools/attack/view_http.py [--short] [--seed N] RICOCHET ATLAS

Starts `ricochet view` on a copy of ATLAS and sends about 2,000 requests that are too long, unfinished, malformed, by the
wrong name or all at once, extensions and stops against each other, and an atlas that is replaced, truncated and deleted
meanwhile. Prints what was not as it should be; exit status 0 if there is nothing. For memory errors give it a program
built with sanitizers."""
import argparse, http.client, json, os, random, shutil, signal, socket, subprocess, sys, tempfile, threading, time

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("--short", action="store_true", help="a twentieth of it, some seconds")
parser.add_argument("--seed", type=int, default=1)
parser.add_argument("ricochet")
parser.add_argument("atlas")
options = parser.parse_args()
print("seed", options.seed)
dice = random.Random(options.seed)
few = 2 if options.short else 20
folder = tempfile.mkdtemp(prefix="ricochet-http-")
atlas = os.path.join(folder, "atlas.ricochet")
shutil.copyfile(options.atlas, atlas)
server = subprocess.Popen([options.ricochet, "view", atlas, "--no-browser", "--port", "0"], stdout=subprocess.PIPE,
                          stderr=open(os.path.join(folder, "err"), "w"), text=True)
address = server.stdout.readline().strip()
host = address.split("/")[2]
port, token = int(host.split(":")[1]), address.split("token=")[1]
asked, wrong, lock = 0, [], threading.Lock()
slack = 10 if b"__asan_init" in open(options.ricochet, "rb").read() else 1


def expect(what, got, *wanted):
    with lock:
        if got not in wanted:
            wrong.append(f"{what}: {got} instead of {' or '.join(map(str, wanted))}")


def ask(method, path, body=None, headers=None, allow=True, timeout=60):
    """The status of one request on a connection of its own, or the name of what went wrong."""
    global asked
    with lock:
        asked += 1
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=timeout)
    try:
        connection.request(method, path, body, {**({"X-Ricochet-Token": token} if allow else {}), **(headers or {})})
        answer = connection.getresponse()
        answer.read()
        return answer.status
    except Exception as error:
        return type(error).__name__
    finally:
        connection.close()


def raw(data, wait=10):
    """The first bytes that come back for these; b"" if the connection is closed without."""
    global asked
    with lock:
        asked += 1
    with socket.create_connection(("127.0.0.1", port), timeout=wait) as s:
        try:
            s.sendall(data)
            return s.recv(64)
        except OSError as error:
            return type(error).__name__.encode()


def alive(when):
    expect(f"after {when}", ask("GET", "/api/status", timeout=20), 200)


def bodies():
    for size in (5_000, 3_000_000, 5_000_000):
        for i in range(few if size > 5_000 else 2):
            body = b"x" * size
            expect(f"POST of {size} bytes", ask("POST", "/api/extend", body), 413)
            expect(f"PUT of {size} bytes", ask("PUT", "/api/extend", body), 405)
            expect(f"{size} bytes by a wrong name", ask("POST", "/api/extend", body, {"Host": "evil.example"}), 421)
            expect(f"{size} bytes in pieces", ask("POST", "/api/extend", iter([body[:3000]] * (size // 3000 + 1))), 413)
    head = f"POST /api/extend HTTP/1.1\r\nHost: {host}\r\nContent-Length: 5000000\r\nExpect: 100-continue\r\n\r\n"
    for i in range(few):
        expect("a question before a body that is too long", raw(head.encode())[:12], b"HTTP/1.1 413")


def values():
    with_length = lambda body: ask("POST", "/api/extend", body)
    for body in ("{}", '{"depth": -5}', '{"depth": 1.5}', '{"depth": "3"}', '{"depth": 1e9}', '{"deep": 3}', "[]", "", "{",
                 '{"energy": 3}', '{"energy": [1, null], "frequency": [1, 2]}', '{"depth": 0}', '{"seconds": -1}'):
        expect(f"an extension {body!r}", with_length(body.encode()), 400)
    expect("nothing of it has begun", json.loads(fetch("/api/status"))["extension"]["running"], False)
    for query in ("branch=1&point=0.5", "branch=1&point=-1", "branch=1.5&point=0", "branch=1&point=nan", "branch=1&energy=inf",
                  "branch=1", "branch=1&point=0&energy=1", "branch=1&point=0%00", "branch=%001&point=0", "branch=1&point=0x1"):
        expect(f"an orbit at {query}", ask("GET", "/api/orbit?" + query), 400)
    for path in ("/api/status%00", "/%00", "/app.js%00.html", "/../etc/passwd", "//", "/api/", "/api/orbit/"):
        expect(f"the page {path}", ask("GET", path), 404)
    for n in (40, 3000):
        expect(f"{n} arguments", ask("GET", "/api/orbit?" + "&".join(f"a{i}=1" for i in range(n))), 400, 414, 431)


def fetch(path):
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=60)
    connection.request("GET", path, headers={"X-Ricochet-Token": token})
    return connection.getresponse().read()


def names():
    """Whoever comes by another name uses up nothing of those who come by the right one."""
    got = set()
    threads = [threading.Thread(target=lambda: [got.add(ask("GET", "/", headers={"Host": "evil.example"}, allow=False)) for _ in range(15 * few)])
               for _ in range(4)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    expect("a wrong name", bool(got - {421, 429}), False)
    for i in range(20):
        expect("the right one meanwhile", ask("GET", "/api/status"), 200)


def slow():
    """Connections that say nothing, or a byte now and then, keep nobody out, and none stays for ever."""
    silent = []
    for i in range(150):
        s = socket.create_connection(("127.0.0.1", port), timeout=60)
        if i % 2:
            try:
                s.send(b"GET / HTT")
            except OSError:
                pass
        silent.append(s)
        if i % 30 == 29:
            begin = time.time()
            expect(f"beside {i + 1} connections that say nothing", ask("GET", "/api/status", timeout=30), 200)
            expect("in time", time.time() - begin < 3 * slack, True)
    drip = silent[-1]
    begin, closed = time.time(), False
    while not closed and time.time() - begin < 20 and not options.short:
        try:
            drip.settimeout(0.5)
            drip.send(b"P")
            closed = drip.recv(10) == b""
        except TimeoutError:
            pass
        except OSError:
            closed = True
    expect("a head that never ends is cut off", closed or options.short, True)
    for s in silent:
        s.close()


def mutated():
    seeds = [f"GET /api/orbit?branch=1&point=0 HTTP/1.1\r\nHost: {host}\r\nX-Ricochet-Token: {token}\r\nConnection: close\r\n\r\n",
             f"POST /api/stop HTTP/1.1\r\nHost: {host}\r\nX-Ricochet-Token: {token}\r\nContent-Length: 2\r\nConnection: close\r\n\r\n{{}}",
             f"POST /api/stop HTTP/1.1\r\nHost: {host}\r\nTransfer-Encoding: chunked\r\nConnection: close\r\n\r\n2\r\n{{}}\r\n0\r\n\r\n"]
    for i in range(30 * few):
        data = bytearray(dice.choice(seeds).encode())
        for _ in range(dice.randint(1, 8)):
            at = dice.randrange(len(data))
            data[at : at + dice.randint(0, 4)] = bytes(dice.randrange(256) for _ in range(dice.randint(0, 4)))
        try:
            raw(bytes(data), 0.3)
        except OSError:
            pass


def races():
    """Extensions and stops against each other, and orbits meanwhile."""
    def one(kind):
        for _ in range(3 * few):
            if kind == 0:
                got, wanted = ask("POST", "/api/extend", b'{"seconds": 1, "depth": 9}'), (200, 400, 409, 429)
            elif kind == 1:
                got, wanted = ask("POST", "/api/stop"), (200, 429)
            else:
                got, wanted = ask("GET", f"/api/orbit?branch={dice.randint(1, 30)}&point=0"), (200, 404, 422, 429)
            expect(("an extension", "a stop", "an orbit", "an orbit")[kind], got, *wanted)
    threads = [threading.Thread(target=one, args=(kind,)) for kind in (0, 0, 1, 2, 3)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    ask("POST", "/api/stop")


def file_changes():
    """What was read before stays on the page, whatever becomes of the file."""
    for change in ("truncate", "garbage", "delete", "replace") * (1 if options.short else 3):
        if change == "truncate":
            with open(atlas, "r+b") as f:
                f.truncate(dice.randrange(1, os.path.getsize(atlas) or 2))
        elif change == "garbage":
            with open(atlas, "wb") as f:
                f.write(dice.randbytes(5000))
        elif change == "delete":
            os.remove(atlas)
        else:
            while json.loads(fetch("/api/status"))["extension"]["running"]:
                time.sleep(0.1) # a file that is replaced under a writer is not SQLite's any more
            shutil.copyfile(options.atlas, atlas + ".new")
            os.replace(atlas + ".new", atlas)
        for _ in range(3):
            expect(f"an orbit after {change}", ask("GET", "/api/orbit?branch=1&point=0"), 200)
            ask("POST", "/api/extend", b'{"seconds": 1, "depth": 9}')
            expect(f"the points after {change}", ask("GET", "/api/points"), 200)
            time.sleep(0.5)
        ask("POST", "/api/stop")
    shutil.copyfile(options.atlas, atlas)


def end():
    """In the midst of an extension the first Ctrl-C ends the server."""
    ask("POST", "/api/extend", b'{"seconds": 60, "depth": 20, "impacts": 30, "multiply": 8}')
    time.sleep(1)
    begin = time.time()
    server.send_signal(signal.SIGINT)
    try:
        expect("the exit code", server.wait(timeout=30), 0)
    except subprocess.TimeoutExpired:
        wrong.append("Ctrl-C does not end it")
        server.kill()
    expect("ends within 3 s", time.time() - begin < 3 * slack, True)


try:
    for part in (values, bodies, names, slow, mutated, races, file_changes):
        begin = time.time()
        part()
        alive(part.__name__)
        print(f"{part.__name__}: {time.time() - begin:.1f} s, {asked} requests so far", flush=True)
    end()
finally:
    if server.poll() is None:
        server.kill()
    said = open(os.path.join(folder, "err")).read()
    if "Sanitizer" in said or "runtime error" in said:
        wrong.append(said[-3000:])
    shutil.rmtree(folder)
print(f"{asked} requests, {len(wrong)} not as they should be")
for line, n in sorted({w: wrong.count(w) for w in wrong}.items()):
    print(f"{n} times: {line}")
sys.exit(bool(wrong))
