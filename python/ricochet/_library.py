"""The C library and its declarations, which are read from include/ricochet.h itself.

Nothing of the header is written down again here: structures, enumerations and functions are what cffi makes of it. The
library is loaded before NumPy, because a process has one LAPACK and the first one that is asked for stays: results are
those of the program, bit for bit, with the reference LAPACK only.
"""
import ctypes.util
import glob
import os
import re
import sys
import warnings


def _find_packages() -> None:
    """A Python beside Debian's own, of the same version, finds the packages of Debian; its own ones come first."""
    debian = "/usr/lib/python3/dist-packages"
    if sys.version_info[:2] == _debian_version() and os.path.isdir(debian) and debian not in sys.path:
        sys.path.append(debian)


def _debian_version() -> tuple:
    """Of /usr/bin/python3, (3, 11); () if there is none."""
    name = re.match(r"python(\d+)\.(\d+)$", os.path.basename(os.path.realpath("/usr/bin/python3")))
    return tuple(map(int, name.groups())) if name else ()


try:
    import cffi
except ImportError:
    _find_packages()
    try:
        import cffi
    except ImportError as missing:
        raise ImportError(f"{missing}; ricochet needs cffi and NumPy (Debian: python3-cffi, python3-numpy; `make python` "
                          f"installs them for /usr/bin/python3, and this is {sys.executable})") from None

_HERE = os.path.dirname(os.path.abspath(__file__))
_TREE = os.path.dirname(os.path.dirname(_HERE))


def _header_path() -> str:
    """That of the source tree, or the copy that an installed package has."""
    for path in (os.path.join(_TREE, "include", "ricochet.h"), os.path.join(_HERE, "ricochet.h")):
        if os.path.exists(path):
            return path
    raise ImportError(f"ricochet.h is neither in {_TREE}/include nor in {_HERE}: install the package once more")


def _library_path() -> str:
    """RICOCHET_LIBRARY, that of an installed package, that of the source tree, or that of the system."""
    named = os.environ.get("RICOCHET_LIBRARY")
    if named and not os.path.exists(named):
        raise ImportError(f"RICOCHET_LIBRARY names {named}, which does not exist")
    for path in (named, os.path.join(_HERE, "libricochet.so"), os.path.join(_TREE, "build", "src", "libricochet.so")):
        if path and os.path.exists(path):
            return path
    found = ctypes.util.find_library("ricochet")
    if found:
        return found
    raise ImportError(f"libricochet.so is neither in {_HERE} nor in {_TREE}/build/src nor in the folders of the system: "
                      "run `make python`")


def _declarations(header: str) -> str:
    """What cffi takes of a header: declarations, and constants that are whole numbers."""
    text = re.sub(r"/\*.*?\*/", "", header, flags=re.DOTALL)
    text = re.sub(r"#ifdef __cplusplus.*?#endif", "", text, flags=re.DOTALL)
    lines = []
    for line in text.splitlines():
        constant = re.match(r"#define (\w+) +\(?(-?\d+)\)?\s*$", line)
        if constant:
            lines.append(f"#define {constant[1]} {constant[2]}")
        elif not line.startswith("#"):
            lines.append(line)
    return "\n".join(lines)


def _check_version(header: str, header_path: str, path: str) -> None:
    """A header and a library that do not belong together would give wrong numbers, not errors."""
    wanted = re.search(r'#define RIC_VERSION "([^"]*)"', header)[1]
    found = ffi.string(lib.ric_version()).decode()
    lacking = [name for name in re.findall(r"\b(ric_\w+)\(", _declarations(header)) if not hasattr(lib, name)]
    in_tree = header_path.startswith(os.path.join(_TREE, "include")) and path.startswith(_TREE + os.sep)
    older = in_tree and os.path.getmtime(path) < os.path.getmtime(header_path)
    if wanted != found or lacking or older:
        what = f"is of version {found} and not {wanted}" if wanted != found else f"lacks {lacking[0]}" if lacking else \
            "is older than its header"
        raise ImportError(f"{path} {what} and does not belong to {header_path}: run `make python`")


def _check_linear_algebra() -> None:
    """Another LAPACK than the reference one, loaded before, takes its place in the whole process.

    Debian keeps the reference libraries in folders of their own, blas/ and lapack/, where the library looks for them;
    elsewhere nothing is known, and nothing said.
    """
    if not glob.glob("/usr/lib/*/lapack/liblapack.so.3"):
        return
    with open("/proc/self/maps", encoding="utf-8", errors="replace") as maps:
        loaded = sorted({line.split()[-1] for line in maps if re.search(r"/lib(blas|lapack)\.so[^/]*$", line.rstrip())})
    for path in loaded:
        if os.path.basename(os.path.dirname(path)) not in ("blas", "lapack"):
            warnings.warn(f"{path} was loaded before ricochet: the last digits may differ from those of the program; import "
                          "ricochet before NumPy and SciPy", RuntimeWarning, stacklevel=4)
            return


def _load():
    header_path, path = _header_path(), _library_path()
    with open(header_path, encoding="utf-8") as file:
        header = file.read()
    ffi.cdef(_declarations(header))
    return header, header_path, path, ffi.dlopen(path)


ffi = cffi.FFI()
_header, _header_file, library_path, lib = _load()
_check_version(_header, _header_file, library_path)
_check_linear_algebra()

try:
    import numpy as np
except ImportError:
    _find_packages()
    import numpy as np


# ------------------------------------------------------------------- errors


class Error(Exception):
    """What the library could not do, in its own words: what is wrong, where, and the remedy."""


class InputError(Error, ValueError):
    """The study, a file or the call is wrong."""


class NumericError(Error, ArithmeticError):
    """A computation could not be carried out to its tolerance."""


class FileError(Error, OSError):
    """A file cannot be read or written."""


class MissingError(FileError, FileNotFoundError):
    """A file that was named is not there."""


class FormatError(FileError):
    """A file is not an atlas, is damaged, or is newer than this library."""


class BusyError(FileError):
    """The atlas is in use by another run."""


class ConflictError(FileError):
    """The atlas belongs to another model."""


class RangeError(Error, LookupError):
    """No such branch, point, junction, orbit or quantity."""


class Interrupted(Error):
    """Stopped on request; what was done is kept."""


_ERRORS = {
    lib.RIC_E_INPUT: InputError,
    lib.RIC_E_NUMERIC: NumericError,
    lib.RIC_E_IO: FileError,
    lib.RIC_E_FORMAT: FormatError,
    lib.RIC_E_BUSY: BusyError,
    lib.RIC_E_CONFLICT: ConflictError,
    lib.RIC_E_RANGE: RangeError,
    lib.RIC_E_INTERRUPTED: Interrupted,
    lib.RIC_E_MISSING: MissingError,
}


def error_of(status: int, detail: str) -> Exception:
    """The exception that stands for a status of the library."""
    text = detail or ffi.string(lib.ric_status_text(status)).decode()
    return MemoryError(text) if status == lib.RIC_E_NOMEM else _ERRORS.get(status, Error)(text)


def detail() -> str:
    """The message of the last error of this thread."""
    return text_of(lib.ric_detail())


def check(status: int) -> None:
    """Raises what a status other than RIC_OK stands for."""
    if status != lib.RIC_OK:
        raise error_of(status, detail())


# ------------------------------------------------------------------- values


def text_of(chars) -> str:
    """A text that the library has given; "" for NULL."""
    return ffi.string(chars).decode("utf-8", "replace") if chars != ffi.NULL else ""


def pointer(array: np.ndarray):
    """The memory of an array of numbers, for the library to read or to fill."""
    names = {"d": "double[]", "i": "int[]", "?": "bool[]"}
    return ffi.from_buffer(names[array.dtype.char], array)


def copy_of(source, count: int, dtype=float) -> np.ndarray:
    """A copy of numbers that the library has lent."""
    return np.frombuffer(ffi.buffer(source, count * ffi.sizeof(ffi.typeof(source).item)), dtype=dtype).copy() if count \
        else np.empty(0, dtype)


def filled(shape, call, dtype=float) -> np.ndarray:
    """A new array that `call(pointer)` fills."""
    array = np.zeros(shape, dtype)
    check(call(pointer(array)))
    return array


def column_of(read, rows: int, name: str, wide: bool) -> np.ndarray:
    """The numbers that `read(name, width, out)` has of so many rows: [rows], or [rows, width] of a wide one; not to be
    written to."""
    width, key = ffi.new("int *"), name.encode()
    check(read(key, width, ffi.NULL))
    array = filled((rows, width[0]) if wide else rows, lambda out: read(key, width, out))
    array.flags.writeable = False
    return array


def fields_of(struct) -> dict:
    """The numbers, flags, enumerations and texts of a structure by their names; pointers to numbers are left out."""
    out = {}
    for name, field in ffi.typeof(struct).fields:
        value = getattr(struct, name)
        if field.type.kind == "primitive" or field.type.kind == "enum":
            out[name] = value
        elif field.type.kind == "array" and field.type.item.cname == "char":
            out[name] = text_of(value)
        elif field.type.kind == "array" and field.type.item.kind == "primitive":
            out[name] = list(value)
        elif field.type.kind == "pointer" and field.type.item.cname == "char":
            out[name] = text_of(value)
    return out


def word_of(model, letters: int, word) -> str:
    """A word as a text: letters 0-9a-z, numbers with dots beyond."""
    room = 12 * letters + 1
    out = ffi.new("char[]", room)
    check(lib.ric_word_format(model, letters, word, room, out))
    return text_of(out)
