"""Profiles from files: plain columns, HDF5 datasets, instrument formats; and what makes a scan a periodic indenter.

A file with exactly as many values as the grid has points is taken as it is, but for the shift to h >= 0. Any other is
resampled, and before that, unless told otherwise, freed of its tilt and made periodic. Every step goes into the result.
"""

import importlib.util
import itertools
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from linecontact.solver import MeasuredIndenter, checks
from linecontact.solver.scene import MAX_POINTS, MIN_POINTS
from numpy.typing import NDArray

from . import confined

Array64 = NDArray[np.float64]

MAX_REFINEMENT = 16  # grid points over values in the file
MAX_VALUES = MAX_POINTS // MAX_REFINEMENT  # numbers in a file: enough for the largest grid
MAX_TEXT = 2**25  # bytes of a text file
LARGEST = 1e100  # number in a file, and its inverse the smallest range: squares are taken
_MAX_LINE = 1000  # characters of a line of numbers
_MAX_HEADER = 1000  # lines before them
_TAPER = 0.1  # share of the length over which a Tukey window falls, at each end
_UNITS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "pm": 1e-12, "angstrom": 1e-10, "inch": 0.0254}

Unit = Literal["m", "mm", "um", "nm", "pm", "angstrom", "inch"]
Detrend = Literal["auto", "none", "mean", "linear"]
Window = Literal["auto", "none", "tukey", "hann", "mirror"]


@dataclass(frozen=True)
class Options:
    """How to read a profile file."""

    path: Path
    num_points: int | None = None
    period: float | None = None
    convention: Literal["gap", "heights"] = "gap"
    dataset: str | None = None
    x_unit: Unit | None = None
    z_unit: Unit | None = None
    length_unit: Unit = "m"
    resample: bool = False
    detrend: Detrend = "auto"
    window: Window = "auto"


def read(options: Options) -> tuple[MeasuredIndenter, float, int]:
    """The indenter, the period [the scene's unit of length] and the number of grid points.

    Raises `ValueError` for a file that is missing, empty, not numbers, constant, not increasing in x, too short, or too
    large: `MAX_VALUES` numbers, `MAX_TEXT` bytes of text.
    """
    path = options.path
    if not os.path.isfile(path):  # Path's own raises for some names
        raise ValueError(f"profile_file is {path}, which is not a file; allowed: .npy, .csv, .txt, .h5, scans")
    try:
        x, z, origin = _load(options)
    except (OSError, EOFError, UnicodeError) as error:
        raise ValueError(f"profile_file {path} cannot be read: {error}") from None
    _check_values(path, x, z)
    x, z = _in_scene_units(x, z, options)
    count = z.size
    as_is, length, n = _choose_grid(options, count)
    steps = [origin]
    if options.convention == "heights":
        z = -z
        steps.append("turned over: peaks up become the indenter's lowest points")
    if x is not None and options.period is not None:
        raise ValueError(f"period is {options.period}; allowed: none, the file has positions")
    if x is None:
        period = checks.real("period", 1.0 if options.period is None else options.period, "a finite length > 0", 0)
    else:
        z, period = _even(x, z, steps)
        period *= length / count
    height = np.ptp(z)
    z = _make_periodic(z, period / length, options, as_is, steps)
    if np.ptp(z) <= 1e-12 * height:
        raise ValueError(f"profile_file {path} holds a straight line; allowed: a profile that is not")
    if z.size != n:
        steps.append(f"resampled from {z.size} to {n} points by Fourier modes")
        z = _resample(z, n, mirrored=as_is is False and length == 2 * count)
    description = {
        "profile_file": _name(path),
        "profile_values": count,
        "profile_convention": options.convention,
        "profile_steps": "; ".join([*steps, "shifted to h >= 0"]),
    }
    return MeasuredIndenter(z, description), period, n


def _choose_grid(options: Options, count: int) -> tuple[bool, int, int]:
    """Whether the values are taken as they are, their number in the period, and the number of grid points."""
    n = options.num_points
    # the default grid is a power of two
    as_is = not options.resample and (count & (count - 1) == 0 if n is None else n == count)
    mirrored = options.window == "mirror" or (options.window == "auto" and not as_is)
    length = 2 * count if mirrored else count
    n = max(16, 2 ** math.ceil(math.log2(length))) if n is None else n
    checks.integer("num_points", n, f"an integer from {MIN_POINTS} to {MAX_POINTS}", MIN_POINTS, MAX_POINTS)
    if n > MAX_REFINEMENT * count:
        raise ValueError(
            f"num_points is {n}; allowed: up to {MAX_REFINEMENT} times the {count} values in {options.path}"
        )
    return as_is, length, n


def _resample(z: Array64, num_points: int, mirrored: bool) -> Array64:
    modes = np.fft.rfft(z)
    held = (min(num_points, z.size) + 1) // 2  # all but an unpaired highest mode
    modes[held:] = 0
    if mirrored:  # the axes stay half-way between two points: the profile stays even
        modes *= np.exp(1j * np.pi * np.arange(modes.size) * (1 / num_points - 1 / z.size))
    return np.asarray(np.fft.irfft(modes[: held + 1], num_points) * (num_points / z.size))


def _load(options: Options) -> tuple[Array64 | None, Array64, str]:
    """Positions (or None), heights, and where they came from."""
    path, dataset = options.path, options.dataset
    suffix = path.suffix.lower()
    if dataset is not None and suffix not in (".h5", ".hdf5"):
        raise ValueError(f"profile_dataset is {dataset}; allowed: none, {path} is not .h5")
    if suffix in (".h5", ".hdf5"):
        return _columns(path, _read_hdf5(path, dataset), f"dataset {dataset or 'only one'} of {_name(path)}")
    if suffix == ".npy":
        try:
            # a map takes no memory for what a header only claims
            with np.errstate(over="raise"):
                array = np.lib.format.open_memmap(path, mode="r")
        except Exception:  # of the tokenizer, for instance
            raise ValueError(f"profile_file {path} is damaged or not a plain array; allowed: real numbers") from None
        return _columns(path, array, f"array of {_name(path)}")
    if suffix in (".csv", ".txt", ".dat", ".asc", ".tsv"):
        table, header = _read_text(path)
        return _columns(path, table, f"columns of {_name(path)}, {header} lines of header left out")
    return _read_scan(options)


def _name(path: Path) -> str:
    """For records, which are UTF-8, as not all names are."""
    return os.fsencode(path.name).decode("utf-8", "backslashreplace")


def _read_text(path: Path) -> tuple[Array64, int]:
    """The table in a text file and the number of lines before it: the first two lines in a row of as many numbers."""
    with path.open("rb") as file:
        content = file.read(MAX_TEXT + 1)
    if len(content) > MAX_TEXT:
        raise ValueError(f"profile_file {path} is too long; allowed: {MAX_TEXT} bytes of text, or .npy or .h5")
    lines = content.decode("utf-8-sig", errors="replace").replace(",", " ").replace(";", " ").splitlines()
    counts = map(_numbers, lines[: _MAX_HEADER + 2])
    first, columns = next(((i, a) for i, (a, b) in enumerate(itertools.pairwise(counts)) if a and a == b), (None, 0))
    if first is None:
        allowed = f"one or two columns behind up to {_MAX_HEADER} lines of header"
        raise ValueError(f"profile_file {path} holds no table of numbers; allowed: {allowed}")
    if columns > 2:
        raise ValueError(f"profile_file {path} has {columns} columns of numbers; allowed: one or two")
    while not lines[-1].strip():
        lines.pop()
    for i in range(first, len(lines)):
        if not lines[i].strip():  # what is before may be a header of numbers
            raise ValueError(f"profile_file {path}, line {i + 1} is empty; allowed: none between numbers")
    try:
        return np.loadtxt(lines[first:], ndmin=2, comments=None), first
    except ValueError as error:
        for i in range(first, len(lines)):
            if _numbers(lines[i]) != columns:
                raise ValueError(
                    f"profile_file {path}, line {i + 1}: {lines[i].strip()[:40]!r} is not {columns} numbers"
                ) from None
        # what float() reads and NumPy does not, like 1_0
        raise ValueError(f"profile_file {path}: {error}; allowed: plain numbers") from None


def _numbers(line: str) -> int:
    """How many numbers a line consists of; 0 if there is anything else."""
    words = line.split() if len(line) <= _MAX_LINE else ["long"]
    try:
        for word in words:
            float(word)
    except ValueError:
        return 0
    return len(words)


def _read_hdf5(path: Path, dataset: str | None) -> Any:
    try:
        return confined.read_dataset(path, MAX_VALUES, dataset)
    except confined.BrokenError as error:
        raise ValueError(f"profile_file {path} is damaged or not HDF5: {error}; allowed: HDF5") from None


def _read_scan(options: Options) -> tuple[Array64 | None, Array64, str]:
    """An instrument's format, through SurfaceTopography, in the scene's unit of length if it names its own."""
    path = options.path
    if importlib.util.find_spec("SurfaceTopography") is None:
        raise ValueError(
            f"profile_file is {path}; allowed: .npy, .csv, .txt, .h5, and with `pip install linecontact[profiles]` the "
            "formats that SurfaceTopography reads"
        )
    try:
        (x, z), unit = confined.read_scan(path, MAX_VALUES)
    except confined.BrokenError as error:
        raise ValueError(
            f"profile_file {path} cannot be read by SurfaceTopography: {error}; allowed: a format that it knows"
        ) from None
    unit = unit.replace("µ", "u")
    if unit not in _UNITS and unit:
        raise ValueError(f"profile_file {path} is in {unit}; allowed: {', '.join(_UNITS)}")
    given = options.x_unit or options.z_unit
    if unit and given:
        raise ValueError(f"x_unit or z_unit is {given}; allowed: none, {path} names its unit, {unit}")
    origin = f"{_name(path)} by SurfaceTopography, in {unit or 'no unit'}"
    scale = _UNITS[unit] / _UNITS[options.length_unit] if unit else 1.0
    return scale * x, scale * z, origin


def _columns(path: Path, table: Any, origin: str) -> tuple[Array64 | None, Array64, str]:
    table = np.asarray(table)
    if table.dtype.kind not in "fiu":
        raise ValueError(f"profile_file {path} holds {str(table.dtype)[:40]}; allowed: real numbers")
    if table.size > MAX_VALUES:
        raise ValueError(f"profile_file {path} holds {table.size} numbers; allowed: up to {MAX_VALUES}")
    with np.errstate(over="ignore"):  # of a longer type: infinite, and refused as such
        table = table.astype(np.float64)
    if table.ndim == 2 and table.shape[1] == 1:
        table = table[:, 0]
    if table.ndim == 1:
        return None, table, origin
    if table.ndim == 2 and table.shape[1] == 2:
        return table[:, 0], table[:, 1], origin
    raise ValueError(f"profile_file {path} has the shape {table.shape}; allowed: one or two columns")


def _check_values(path: Path, x: Array64 | None, z: Array64) -> None:
    if z.size < 16:
        raise ValueError(f"profile_file {path} holds {z.size} values; allowed: at least 16")
    for name, values in (("x", x), ("height", z)):
        if values is None:
            continue
        bad = np.flatnonzero(~(np.abs(values) <= LARGEST))
        if bad.size:
            what = "too large" if np.isfinite(values[bad[0]]) else "not finite"
            allowed = f"finite numbers up to {LARGEST:g}"
            raise ValueError(f"profile_file {path}: {name} number {bad[0] + 1} is {what}; allowed: {allowed}")
        if 0 < np.ptp(values) < 1 / LARGEST:
            reason = f"{name} ranges over {np.ptp(values)}; allowed: {1 / LARGEST:g} and more"
            raise ValueError(f"profile_file {path}: {reason}")
    if np.ptp(z) == 0:
        raise ValueError(f"profile_file {path}: every height is {z[0]}; allowed: a profile that is not constant")
    if x is not None:
        bad = np.flatnonzero(np.diff(x) <= 0)
        if bad.size:
            raise ValueError(
                f"profile_file {path}: x goes from {x[bad[0]]} to {x[bad[0] + 1]} at value {bad[0] + 2}; allowed: "
                "increasing (in text a comma separates columns)"
            )


def _in_scene_units(x: Array64 | None, z: Array64, options: Options) -> tuple[Array64 | None, Array64]:
    """Both axes in the scene's unit of length; without a unit they are taken to be in it."""
    scene = _UNITS[options.length_unit]
    if options.x_unit and x is None:
        raise ValueError(f"x_unit is {options.x_unit}; allowed: none, the file has no positions (give the period)")
    if options.x_unit and x is not None:
        x = x * (_UNITS[options.x_unit] / scene)
    if options.z_unit:
        z = z * (_UNITS[options.z_unit] / scene)
    return x, z


def _even(x: Array64, z: Array64, steps: list[str]) -> tuple[Array64, float]:
    """Heights at even spacing, and the length of the scan, one spacing a value.

    Positions that are even but for their rounding are taken as even.
    """
    i = np.arange(x.size) - (x.size - 1) / 2
    spacing = float(i @ x) / float(i @ i)  # least squares
    off = float(np.abs(x - x.mean() - spacing * i).max()) / spacing
    if off < 0.5:
        steps.append(f"positions even to {off:.2g} of the spacing {spacing:.6g}, taken as even")
        return z, spacing * x.size
    even = np.linspace(x[0], x[-1], x.size)
    gap = float(np.diff(x).max()) / (even[1] - even[0])
    steps.append(f"interpolated linearly to even spacing, the largest gap {gap:.3g} spacings")
    return np.asarray(np.interp(even, x, z)), float(x[-1] - x[0]) * x.size / (x.size - 1)


def _make_periodic(z: Array64, spacing: float, options: Options, as_is: bool, steps: list[str]) -> Array64:
    """Tilt and window, by default a line and the mirror image for everything that is not taken as it is.

    The mirror image doubles the length but keeps the roughness; the windows smooth it away at the ends, where a scan
    then touches nearly everywhere.
    """
    detrend, window = options.detrend, options.window
    if detrend == "auto":
        detrend = "none" if as_is else "linear"
    if window == "auto":
        window = "none" if as_is else "mirror"
    if detrend == "linear":
        i = np.arange(z.size) - (z.size - 1) / 2
        slope = float(i @ z) / float(i @ i)
        steps.append(f"tilt of {slope / spacing:.4g} removed (least squares)")
        z = z - slope * i
    if detrend != "none" or window in ("tukey", "hann"):
        steps.append("mean removed")
        z = z - z.mean()
    if window == "mirror":
        steps.append("made periodic by its mirror image")
        return np.concatenate([z, z[::-1]])
    if window != "none":
        taper = 0.5 if window == "hann" else _TAPER
        ramp = np.minimum(np.arange(z.size) + 0.5, z.size - 0.5 - np.arange(z.size)) / (taper * z.size)
        z = z * np.sin(np.pi / 2 * np.minimum(ramp, 1.0)) ** 2
        steps.append(f"made periodic by a {window} window, falling over {taper:g} of the length at each end")
    return z
