"""Profiles from files: plain columns, HDF5 datasets, instrument formats; and what makes a scan a periodic indenter.

A file with exactly as many values as the grid has points is taken as it is, but for the shift to h >= 0. Any other is
resampled, and before that, unless told otherwise, freed of its tilt and made periodic. Every step goes into the result.
"""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import h5py
import numpy as np
from linecontact.solver import MeasuredIndenter
from numpy.typing import NDArray

Array64 = NDArray[np.float64]

MAX_REFINEMENT = 16  # grid points over values in the file
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

    Raises `ValueError` for a file that is missing, empty, not numbers, constant, not increasing in x, or too short.
    """
    path = options.path
    if not path.is_file():
        raise ValueError(f"profile_file is {path}, which is not a file; allowed: .npy, .csv, .txt, .h5, scans")
    try:
        x, z, origin = _load(path, options.dataset)
    except (OSError, EOFError, UnicodeError) as error:
        raise ValueError(f"profile_file {path} cannot be read: {error}") from None
    _check_values(path, x, z)
    x, z = _in_scene_units(x, z, options, origin)
    count = z.size
    n = options.num_points or max(16, 2 ** math.ceil(math.log2(count)))
    if n > MAX_REFINEMENT * count:
        raise ValueError(f"num_points is {n}; allowed: up to {MAX_REFINEMENT} times the {count} values in {path}")
    steps = [origin]
    if options.convention == "heights":
        z = -z
        steps.append("turned over: peaks up become the indenter's lowest points")
    as_is = n == count and not options.resample
    length = _length(x, options, count)
    if x is not None:
        z = _even(x, z, steps)
    z, length = _make_periodic(z, length, options, as_is, steps)
    if z.size != n:
        modes = np.fft.rfft(z)
        held = min(n, z.size) // 2
        modes[held:] = 0
        steps.append(f"resampled from {z.size} to {n} points by Fourier modes")
        z = np.fft.irfft(modes[: held + 1], n) * (n / z.size)
    description = {
        "profile_file": path.name,
        "profile_values": count,
        "profile_convention": options.convention,
        "profile_steps": "; ".join([*steps, "shifted to h >= 0"]),
    }
    return MeasuredIndenter(z, description), length, n


def _load(path: Path, dataset: str | None) -> tuple[Array64 | None, Array64, str]:
    """Positions (or None), heights, and where they came from."""
    suffix = path.suffix.lower()
    if suffix in (".h5", ".hdf5"):
        return _columns(path, _read_hdf5(path, dataset), f"dataset {dataset or 'only one'} of {path.name}")
    if suffix == ".npy":
        try:
            return _columns(path, np.load(path, allow_pickle=False), f"array of {path.name}")
        except ValueError as error:
            raise ValueError(f"profile_file {path} is not a plain array: {error}") from None
    if suffix in (".csv", ".txt", ".dat", ".asc", ".tsv"):
        table, header = _read_text(path)
        return _columns(path, table, f"columns of {path.name}, {header} lines of header left out")
    return _read_scan(path)


def _read_text(path: Path) -> tuple[Array64, int]:
    """The table in a text file and the number of lines before it: the first two lines in a row of as many numbers."""
    lines = path.read_text("utf-8", errors="replace").replace(",", " ").replace(";", " ").splitlines()
    counts = [_numbers(line) for line in lines]
    first = next((i for i in range(len(lines) - 1) if counts[i] and counts[i] == counts[i + 1]), None)
    if first is None:
        raise ValueError(f"profile_file {path} holds no table of numbers; allowed: one or two columns")
    used = [i for i in range(first, len(lines)) if lines[i].strip()]
    for i in used:
        if counts[i] != counts[first]:
            raise ValueError(
                f"profile_file {path}, line {i + 1}: {lines[i].strip()[:40]!r} is not {counts[first]} numbers"
            )
    return np.loadtxt([lines[i] for i in used], ndmin=2), first


def _numbers(line: str) -> int:
    """How many numbers a line consists of; 0 if there is anything else."""
    words = line.split()
    try:
        for word in words:
            float(word)
    except ValueError:
        return 0
    return len(words)


def _read_hdf5(path: Path, dataset: str | None) -> Any:
    with h5py.File(path, "r") as file:
        names: list[str] = []
        file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        if dataset is None and len(names) == 1:
            dataset = names[0]
        if dataset not in names:
            raise ValueError(f"profile_dataset is {dataset!r}; allowed in {path}: {', '.join(names) or 'nothing'}")
        data = file[dataset]
        if data.size > 2**31 or data.dtype.kind not in "fiu":
            raise ValueError(f"profile_dataset is {dataset!r}, which is not an array of numbers")
        return data[()]


def _read_scan(path: Path) -> tuple[Array64 | None, Array64, str]:
    """An instrument's format, through SurfaceTopography."""
    try:
        import SurfaceTopography
    except ImportError:
        raise ValueError(
            f"profile_file is {path}; allowed: .npy, .csv, .txt, .h5, and with `pip install linecontact[profiles]` the "
            "formats that SurfaceTopography reads"
        ) from None
    try:
        scan = SurfaceTopography.read_topography(str(path))
        if scan.dim != 1:
            raise ValueError("it is a map; allowed: a line scan")
        x, z = scan.positions(), scan.heights()
    except Exception as error:  # its readers raise anything
        raise ValueError(f"profile_file {path} cannot be read by SurfaceTopography: {error}") from None
    return np.asarray(x, float), np.asarray(np.ma.filled(z, np.nan), float), f"{path.name} by SurfaceTopography"


def _columns(path: Path, table: Any, origin: str) -> tuple[Array64 | None, Array64, str]:
    table = np.asarray(table)
    if table.dtype.kind not in "fiu":
        raise ValueError(f"profile_file {path} holds {table.dtype}; allowed: real numbers")
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
        bad = np.flatnonzero(~np.isfinite(values if values is not None else z))
        if bad.size:
            raise ValueError(f"profile_file {path}: {name} number {bad[0] + 1} is not finite; allowed: finite numbers")
    if np.ptp(z) == 0:
        raise ValueError(f"profile_file {path}: every height is {z[0]}; allowed: a profile that is not constant")
    if x is not None:
        bad = np.flatnonzero(np.diff(x) <= 0)
        if bad.size:
            raise ValueError(
                f"profile_file {path}: x goes from {x[bad[0]]} to {x[bad[0] + 1]} at value {bad[0] + 2}; allowed: "
                "increasing"
            )


def _in_scene_units(x: Array64 | None, z: Array64, options: Options, origin: str) -> tuple[Array64 | None, Array64]:
    """Both axes in the scene's unit of length; without a unit they are taken to be in it."""
    scene = _UNITS[options.length_unit]
    if options.x_unit and x is not None:
        x = x * (_UNITS[options.x_unit] / scene)
    if options.z_unit:
        z = z * (_UNITS[options.z_unit] / scene)
    return x, z


def _length(x: Array64 | None, options: Options, count: int) -> float:
    """Length of the scan, one spacing per value."""
    if x is None:
        return 1.0 if options.period is None else options.period
    if options.period is not None:
        raise ValueError(f"period is {options.period}; allowed: none, the file has positions")
    return float(_fit(x)[1] - _fit(x)[0]) * count / (count - 1)


def _fit(x: Array64) -> tuple[float, float]:
    """First and last of the even positions nearest to `x` (least squares)."""
    i = np.arange(x.size) - (x.size - 1) / 2
    half = float(i @ x) / float(i @ i) * i[-1]
    return float(x.mean()) - half, float(x.mean()) + half


def _even(x: Array64, z: Array64, steps: list[str]) -> Array64:
    """Heights at even spacing; positions that are even but for their rounding are taken as even."""
    even = np.linspace(*_fit(x), x.size)
    off = float(np.abs(x - even).max()) / (even[1] - even[0])
    if off < 0.5:
        steps.append(f"positions even to {off:.2g} of the spacing {even[1] - even[0]:.6g}, taken as even")
        return z
    steps.append("interpolated linearly to even spacing")
    return np.asarray(np.interp(even, x, z))


def _make_periodic(z: Array64, length: float, options: Options, as_is: bool, steps: list[str]) -> tuple[Array64, float]:
    """Tilt and window, by default a line and a Tukey window for everything that is not taken as it is."""
    detrend, window = options.detrend, options.window
    if detrend == "auto":
        detrend = "none" if as_is else "linear"
    if window == "auto":
        window = "none" if as_is else "tukey"
    if detrend == "linear":
        i = np.linspace(-1, 1, z.size)
        slope = float(i @ z) / float(i @ i)
        steps.append(f"tilt of {2 * slope / length:.4g} removed (least squares)")
        z = z - slope * i
    if detrend != "none":
        z = z - z.mean()
    if window == "mirror":
        steps.append("made periodic by its mirror image, twice as long")
        return np.concatenate([z, z[::-1]]), 2 * length
    if window != "none":
        taper = 0.5 if window == "hann" else _TAPER
        ramp = np.minimum(np.arange(z.size) + 0.5, z.size - 0.5 - np.arange(z.size)) / (taper * z.size)
        z = z * np.sin(np.pi / 2 * np.minimum(ramp, 1.0)) ** 2
        steps.append(f"made periodic by a {window} window, falling over {taper:g} of the length at each end")
    return z, length
