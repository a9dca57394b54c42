"""Files of others, read by a process of its own, with little memory and time, before this one touches them.

HDF5's library crashes or never comes back on some broken files; such a file may also ask for other files, for plugins,
or for more memory than there is; and the readers of instruments' formats promise nothing. This file is the script of
that process, too: `python confined.py dataset | scan FILE [...]`, which imports no other module of ours.
"""

import contextlib
import json
import math
import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import h5py

MEMORY = 4 * 2**30
"""Bytes of data that the process may have, besides the size of the file."""
SECONDS = 6
"""Of processor time, and one more for each 64 MiB of the file; three times that by the clock."""

_FILTERS = {1: "gzip", 2: "shuffle", 3: "fletcher32", 4: "szip", 5: "nbit", 6: "scaleoffset", 32000: "lzf"}
_PACKED = {"scale_factor": 1, "add_offset": 1, "valid_min": 1, "valid_max": 1, "valid_range": 2}
_PACKED |= {"_FillValue": 0, "missing_value": 0}  # numbers in each; 0: any
_UNIT = re.compile(r"(?:^|_)units?$", re.I)  # names of attributes
_PACKING = re.compile(
    r"(?!DIMENSION_).*(?:scale|factor|gain|offset|calibration|multiplier|unsigned|conversion|lsb|bit2|_per_|sensitivity"
    r"|quantum)",
    re.I,
)


class RefusedError(ValueError):
    """A file with a forbidden request; the message names it."""


class BrokenError(ValueError):
    """A file that its library cannot read; the message says why."""


class Columns(NamedTuple):
    """Numbers that the process has read."""

    values: NDArray[Any]
    """As the file has them."""
    unit: str
    """The file's own unit, empty if it names none."""
    label: str = ""
    """Their name in the file, and words about them there."""


def read_dataset(path: Path, most: int, name: str | None) -> Columns:
    """Read a dataset of up to `most` numbers of an HDF5 file; without a name its only one. Raises like `_run`."""
    return _run("dataset", path, str(most), *([] if name is None else [name]))


def read_scan(path: Path, most: int) -> Columns:
    """Read positions and heights of a line scan, shape (2, N), N up to `most`, and their unit. Raises like `_run`."""
    return _run("scan", path, str(most))


def _run(what: str, path: Path, *more: str) -> Columns:
    """Have a file read by a process of its own. Raises `RefusedError` and `BrokenError`."""
    seconds = SECONDS + path.stat().st_size // 2**26
    # -P: nothing is imported from the folder of the file; "::": no plugin is loaded
    command = [sys.executable, "-P", __file__, what, str(seconds), str(path), *more]
    environment = os.environ | {"HDF5_PLUGIN_PRELOAD": "::", "OPENBLAS_NUM_THREADS": "1"}
    quiet = subprocess.DEVNULL
    try:
        done = subprocess.run(
            command, stdin=quiet, stdout=subprocess.PIPE, stderr=quiet, env=environment, timeout=3 * seconds
        )
    except subprocess.TimeoutExpired:
        raise BrokenError(f"its library did not come back within {3 * seconds} s") from None
    head = done.stdout[: done.stdout.find(b"\n") + 1]
    if done.returncode or not head:
        raise BrokenError(f"its library crashed, or took more than {seconds} s or {MEMORY >> 30} GiB")
    answer = json.loads(head)
    if "refused" in answer:
        raise RefusedError(answer["refused"])
    if "broken" in answer:
        raise BrokenError(answer["broken"])
    values = np.frombuffer(done.stdout, answer["dtype"], offset=len(head))
    return Columns(values.reshape(answer["shape"]), answer["unit"], answer["label"])


def _dataset(path: str, most: str, name: str | None = None) -> Columns:
    import h5py

    with h5py.File(path, "r") as file:
        names: list[str] = []
        # links to elsewhere are not followed
        file.visititems(lambda key, item: names.append(key) if isinstance(item, h5py.Dataset) else None)
        if name is None and len(names) == 1:
            name = names[0]
        if name not in names:
            some = ", ".join(names[:20]) + (", ..." if len(names) > 20 else "")
            raise RefusedError(
                f"profile_dataset is {'missing' if name is None else repr(name)}; allowed: {some}"
                if names
                else "it holds no dataset; allowed: one of numbers, in the file itself"
            )
        data = file[name]
        if data.shape is None or data.dtype.kind not in "fiu":
            raise RefusedError(f"profile_dataset is {name!r}, which is not an array of numbers")
        if math.prod(data.shape) > int(most):
            raise RefusedError(f"profile_dataset is {name!r} of shape {data.shape}; allowed: up to {most} numbers")
        _check_storage(data, f"profile_dataset is {name!r}", 16 * int(most))
        groups = [file, data.parent]
        words = [key for key in data.attrs if not (_UNIT.search(key) or _is_number(data.attrs[key]))]
        label = [*str(name).split("/"), *(_text(data, key) for key in words)]
        units = (_text(item, key) for item in (data, *groups) for key in item.attrs if _UNIT.search(key))
        unit = ",".join(dict.fromkeys(units))
        for above in groups:
            for key in filter(_PACKING.match, above.attrs):
                raise RefusedError(
                    f"profile_dataset is {name!r}, in a group whose attribute {key!r} may change it; allowed: none"
                )
        return Columns(_unpacked(data[()], data.attrs, f"profile_dataset is {name!r}"), unit, " ".join(label).strip())


def _is_number(value: object) -> bool:
    return np.asarray(value).dtype.kind in "biufc"


def _text(item: "h5py.Dataset | h5py.Group", name: str) -> str:
    """An attribute as text, empty without it."""
    found = np.ravel(item.attrs.get(name, ""))
    return " ".join(one.decode(errors="replace") if isinstance(one, bytes) else str(one) for one in found)[:100]


def _unpacked(values: NDArray[Any], attributes: "h5py.AttributeManager", what: str) -> NDArray[Any]:
    """Values times `scale_factor` plus `add_offset`, NaN where missing: the attributes of the CF conventions, 8.1."""
    given = dict[str, NDArray[np.float64]]()
    for name in attributes:
        if name in _PACKED:
            number = np.ravel(attributes[name])
            good = number.dtype.kind in "fiu" and number.size == (_PACKED[name] or number.size)
            linear = name in ("scale_factor", "add_offset")
            if not good or (linear and not np.isfinite(number[0])) or (name == "scale_factor" and number[0] == 0):
                raise RefusedError(f"{what}, whose attribute {name} is {str(attributes[name])[:40]}; allowed: a number")
            given[name] = number.astype(np.float64)
        elif _PACKING.match(name) or (values.dtype.kind in "iu" and _is_number(attributes[name])):
            raise RefusedError(f"{what}, whose attribute {name!r} may change it; allowed: {', '.join(_PACKED)}")
    if not given:
        return values
    found = values.astype(np.float64)
    low, high = given.get("valid_range", np.array([-np.inf, np.inf]))
    wrong = np.isin(found, [*given.get("_FillValue", ()), *given.get("missing_value", ())])
    wrong |= (found < given.get("valid_min", low)) | (found > given.get("valid_max", high))
    found[wrong] = np.nan
    return found * given.get("scale_factor", 1.0) + given.get("add_offset", 0.0)


def _check_storage(data: "h5py.Dataset", what: str, most: int) -> None:
    """Refuse data outside of the file itself, or more than `most` bytes."""
    if data.is_virtual or data.external:
        raise RefusedError(f"{what}, which is kept in other files; allowed: data in the file itself")
    properties = data.id.get_create_plist()
    filters = [properties.get_filter(i)[0] for i in range(properties.get_nfilters())]
    if not set(filters) <= set(_FILTERS):
        raise RefusedError(f"{what}, packed by filters {filters}; allowed: {', '.join(_FILTERS.values())}")
    size = max(math.prod(data.shape), math.prod(data.chunks or ())) * data.dtype.itemsize
    if size > most:
        raise RefusedError(f"{what} of {size} bytes, chunks included; allowed: up to {most}")


def _scan(path: str, most: str) -> Columns:
    import SurfaceTopography

    scan = SurfaceTopography.read_topography(path)
    if scan.dim != 1:
        raise BrokenError("it is a map; allowed: a line scan")
    if scan.nb_grid_pts[0] > int(most):
        raise BrokenError(f"it holds {scan.nb_grid_pts[0]} values; allowed: up to {most}")
    z: NDArray[Any] = np.ma.filled(np.ma.asarray(scan.heights(), float), np.nan)
    return Columns(np.stack([np.asarray(scan.positions(), float), z]), str(scan.unit or ""))


def _limit(seconds: int, memory: int) -> None:
    with contextlib.suppress(ImportError, ValueError, OSError):  # not POSIX, or a tighter limit already
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        resource.setrlimit(resource.RLIMIT_DATA, (memory, memory))


def _main(what: str, seconds: str, *arguments: str) -> None:
    """The work of the process: answer on standard output with a line of JSON, then the values."""
    output = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # the output of libraries is no answer
    _limit(int(seconds), MEMORY + os.path.getsize(arguments[0]))
    tasks: dict[str, Callable[..., Columns]] = {"dataset": _dataset, "scan": _scan}
    values = np.zeros(0)
    answer: dict[str, Any]
    try:
        values, unit, label = tasks[what](*arguments)
        answer = {"unit": unit, "label": label, "dtype": values.dtype.str, "shape": values.shape}
    except RefusedError as error:
        answer = {"refused": str(error)}
    except Exception as error:  # libraries raise anything
        answer = {"broken": " ".join(f"{error or type(error).__name__}".split())[:200]}
    output.write(json.dumps(answer).encode() + b"\n")
    output.write(values.tobytes())
    output.close()


if __name__ == "__main__":
    _main(*sys.argv[1:])
