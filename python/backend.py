"""Makes the wheel of the package: what `pip install .` calls (PEP 517, PEP 660), with the standard library alone.

A wheel is an archive; a build tool from a registry would be the only thing that `pip install .` needs the network for.
The package carries the built library and the header that belongs to it.
"""
import base64
import hashlib
import os
import re
import subprocess
import sysconfig
import zipfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)
HEADER = os.path.join(ROOT, "include", "ricochet.h")
NEEDS = ["numpy>=1.20", "cffi>=1.14"]
EXTRAS = {"all": ["scipy>=1.8", "matplotlib>=3.4"]}


def _version():
    with open(HEADER, encoding="utf-8") as file:
        return re.search(r'#define RIC_VERSION "([^"]*)"', file.read())[1]


def _library():
    """The built library; builds it, offline, if there is none."""
    path = os.environ.get("RICOCHET_LIBRARY") or os.path.join(ROOT, "build", "src", "libricochet.so")
    if not os.path.exists(path):
        subprocess.run(["make", "-C", ROOT, "build"], check=True)
    return path


def _metadata():
    lines = ["Metadata-Version: 2.1", "Name: ricochet", f"Version: {_version()}",
             "Summary: Periodic orbits of linear structures with rigid stops", "License: BSD-3-Clause",
             "Requires-Python: >=3.9", *(f"Requires-Dist: {need}" for need in NEEDS)]
    for extra, needs in EXTRAS.items():
        lines += [f"Provides-Extra: {extra}", *(f"Requires-Dist: {need}; extra == '{extra}'" for need in needs)]
    return "\n".join(lines) + "\n"


def _tag():
    return f"py3-none-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"


def _sources():
    folder = os.path.join(HERE, "ricochet")
    for name in sorted(os.listdir(folder)):
        if name.endswith((".py", ".typed")):
            yield f"ricochet/{name}", os.path.join(folder, name)
    yield "ricochet/ricochet.h", HEADER
    yield "ricochet/libricochet.so", os.path.realpath(_library())


def _digest(data):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def _write(folder, files):
    """The archive, and its name; files is a list of (name, bytes)."""
    info, tag = f"ricochet-{_version()}.dist-info", _tag()
    files = [*files, (f"{info}/METADATA", _metadata().encode()), (f"{info}/WHEEL", (
        f"Wheel-Version: 1.0\nGenerator: ricochet\nRoot-Is-Purelib: false\nTag: {tag}\n").encode())]
    record = "".join(f"{name},{_digest(data)},{len(data)}\n" for name, data in files) + f"{info}/RECORD,,\n"
    wheel = f"ricochet-{_version()}-{tag}.whl"
    with zipfile.ZipFile(os.path.join(folder, wheel), "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in [*files, (f"{info}/RECORD", record.encode())]:
            archive.writestr(name, data)
    return wheel


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """The package with the library inside."""
    files = []
    for name, path in _sources():
        with open(path, "rb") as file:
            files.append((name, file.read()))
    return _write(wheel_directory, files)


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    """A pointer to this folder."""
    return _write(wheel_directory, [("ricochet.pth", (HERE + "\n").encode())])


def get_requires_for_build_wheel(config_settings=None):
    """Nothing."""
    return []


get_requires_for_build_editable = get_requires_for_build_wheel
