"""From a file to an indenter. Nothing is guessed: a file that leaves something open is refused, with options to add."""

import math
import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from linecontact.solver import ElasticLayer, MeasuredIndenter, Scene, checks
from linecontact.solver.display import counted
from linecontact.solver.grid.errors import DEFAULT_QUANTITY, check_accuracy
from linecontact.solver.scene import MAX_POINTS, MIN_POINTS
from linecontact.solver.transforms.plain import next_fast_len
from linecontact.solver.units import SCENE, named

from ..files.writing import as_path
from ..terminal.options import options_of, refused, text
from ..terminal.text import is_refusal, shown_name
from ..terminal.units import UNITS, Unit
from . import columns
from .columns import MAX_REFINEMENT
from .header import DEEP
from .missing import DOUBTED, Missing, doubtful, filled, marked, spikes
from .preparation import Detrend, Profile, Window, evenly_spaced
from .text import Decimal, Table

_FEWEST, _POINTS_PER_VALUE, _ENOUGH = 16, 4, 2**18  # values; points of the default grid for each, up to so many
_DEFAULT: Unit = "m"  # of the scene's lengths
Convention = Literal["heights", "gap"]


@dataclass(frozen=True)
class Options:
    """A scan or another profile from a file. Its length is the period, with its mirror image half of it."""

    profile_file: Path
    """The file: text (.csv, .txt, .dat, .asc, .tsv), .npy, .h5, or an instrument's format."""
    num_points: int | None = None
    """Grid points, up to 16 for each value; default: a power of two, mostly 4 or more each; with an accuracy 16."""
    x_unit: Unit | None = None
    """Unit of the positions, where the file names none."""
    z_unit: Unit | None = None
    """Unit of the heights, where the file names none."""
    scene_units: bool = False
    """Numbers for which no unit is known are in the scene's own unit of length, which --length-unit may name."""
    length_unit: Unit | None = None
    """Unit of the scene's lengths, of results and of numbers alone; default: m, and lengths have units, like 2mm."""
    scan_length: float | None = None
    """Length of a scan without positions [length], its spacing times its number of values."""
    columns: str | None = text("text, like '2,3'", None)
    """Columns of x and z, counted from 1, like 2,3; or of z alone, like 3."""
    decimal: Decimal | None = None
    """Decimal sign of a text, where the file leaves it open."""
    profile_convention: Convention | None = None
    """Heights have their peaks up, as a scan has them; gap is h, the distance of the indenter. Default: heights."""
    profile_dataset: str | None = text("text, the name of a dataset", None)
    """Name of the dataset in an .h5 file that holds several."""
    missing: Missing | None = None
    """Fill missing values by straight lines (interpolate), or leave their rows out (drop), which needs positions.
    Default: refuse, but interpolate for those of --invalid and --despike."""
    invalid: str | None = text("text, like '-9999'", None)
    """Numbers that stand for missing heights, like -9999, parted by commas."""
    despike: bool = False
    """Take outliers, which stand out from the values around them like dust, for missing values."""
    detrend: Detrend | None = None
    """Remove the mean, also the tilt (linear), also a bow (curvature); default: linear, but none with --window none."""
    window: Window = "mirror"
    """How the profile is made periodic: its mirror image, or nothing if it is periodic."""
    period: float | None = refused()
    """Not with a file."""
    accuracy: float | None = None
    """Relative error wanted of a_r (dimensionless); it chooses the grid."""

    def __post_init__(self) -> None:
        """The checks of the command line, for Python. Raises `ValueError`."""
        for name, option in options_of(Options).items():
            value = getattr(self, name)
            if option.choices and not (value is option.default is None):
                checks.choice(name, value, option.choices)
            elif option.type in (bool, str, Path) and not (isinstance(value, option.type) or value is option.default):
                raise checks.refusal(name, value, option.said or "True or False")
        check_accuracy(self.accuracy, DEFAULT_QUANTITY)


class Scan(NamedTuple):
    """A scan as an indenter, with the period and the grid that a `Scene` of it needs."""

    indenter: MeasuredIndenter  # with all that is known of the scan in its `description`
    period: float  # of the scene [length]
    num_points: int  # of the scene's grid

    def __repr__(self) -> str:
        unit = named(self.indenter.description)["length"]
        return f"Scan: period {self.period:.6g} [{unit}], num_points {self.num_points}; {self.indenter}"

    def scene(self, layer: ElasticLayer, pressure: float | None = None, approach: float | None = None) -> Scene:
        """The scan under a mean pressure [pressure], or an approach [length] in its unit. Raises `ValueError`."""
        if pressure is None and approach is None:
            raise ValueError("pressure (or approach) is missing; allowed: one of the two, in the units of the layer")
        if getattr(layer, "has_default_modulus", False):  # else `Scene` says that it is no layer
            allowed = "its E* must be given, in one unit with the pressure, because lengths have units"
            raise ValueError(f"contact_modulus of the layer is missing; allowed: {allowed}")
        load = math.nan if pressure is None else pressure
        return Scene(layer, self.indenter, load, self.period, self.num_points, approach=approach)


def read_scan(path: str | os.PathLike[str], **options: Any) -> Scan:
    """Read a scan from a file as a `Scan`: indenter, period and number of grid points, which a `Scene` takes.

    path: the file. options: as the fields of `Options` say, for instance `x_unit="um"`, `z_unit="nm"`,
    `scan_length=1e-3`, `num_points=2**14`. Lengths of the scene are in metres unless `length_unit` says otherwise.
    Raises `ValueError` for a file that cannot be read, leaves an option open, or is no profile.
    """
    allowed = [field.name for field in fields(Options) if field.name not in ("profile_file", "period")]
    if wrong := [name for name in options if name not in (*allowed, "period")]:
        raise ValueError(f"option is {wrong[0]!r}; allowed: {', '.join(allowed)}")
    return read(Options(as_path("path", path), **options))


def read(options: Options) -> Scan:
    """As `read_scan`."""
    try:
        return _read(options)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) or is_refusal(error):
            raise ValueError(f"profile_file {options.profile_file}: {error}") from None
        raise


def _read(options: Options) -> Scan:
    """As `read`, but errors do not name the file."""
    if not os.path.isfile(options.profile_file):  # Path's own raises for some names
        raise ValueError("this is not a file; allowed: an existing file")
    if options.period is not None:
        allowed = "none with a file, whose scan is the period, with its mirror image half of it"
        raise ValueError(f"period is {options.period}; allowed: {allowed} (without positions, scan_length tells it)")
    found = columns.load(options.profile_file, options.profile_dataset, options.columns, options.decimal)
    found, told, doubts = _complete(found, options)
    profile, units = _measured(found, options)
    profile.steps[:0], profile.doubts[:0] = told, doubts
    count, scan = profile.z.size, _statistics(profile)
    said = next(filter(DEEP.search, [found.labels["z"].text, *found.head.rest]), "")
    if said and options.profile_convention is None:
        seen = f"the file speaks of depths or gaps ({said[:60]!r})"
        allowed = "heights, if its values grow towards the peaks, or gap, if they grow into the valleys"
        raise ValueError(f"profile_convention is missing: {seen}; allowed: {allowed}")
    if options.profile_convention != "gap":
        profile.z = -profile.z
        profile.steps.append("heights turned over: peaks up become the indenter's lowest points")
    height = np.ptp(profile.z)
    profile.detrend("none" if options.window == "none" and options.detrend is None else options.detrend)
    if np.ptp(profile.z) <= 1e-12 * height:
        raise ValueError("it holds a straight line, or a parabola; allowed: a profile, of which detrend leaves more")
    profile.make_periodic(options.window)
    measured = profile.z.size
    n = _choose_grid(options, count, measured)
    profile.resample(n)
    description = {
        "profile_file": shown_name(options.profile_file),
        "profile_convention": options.profile_convention or "heights",
        "profile_values": count,
        **{f"profile_{axis}_unit": unit for axis, unit in units.items()},
        "profile_length_unit": SCENE if set(units.values()) == {SCENE} else options.length_unit or _DEFAULT,
        **scan,
        **{f"profile_{name}": "; ".join(of) for name, of in (("missing", told), ("doubts", profile.doubts)) if of},
        "profile_steps": "; ".join([found.origin, *profile.steps, "shifted to h >= 0"]),
    }
    indenter = MeasuredIndenter(profile.z, measured, description, profile.length, convention="gap")
    return Scan(indenter, profile.length, n)


def _complete(found: Table, options: Options) -> tuple[Table, list[str], list[str]]:
    """The columns without missing values, the changes, and the doubts. Raises `ValueError`."""
    values = found.values.copy()
    z, alone = values[:, -1], values.shape[1] == 1
    if alone and z[0] == z.size - 1 >= _FEWEST:
        raise ValueError(f"{found.row(0)}: {z[0]:g} is the number of the values below it; allowed: heights alone")
    how, told = options.missing or ("refuse" if np.isnan(values).any() else "interpolate"), list[str]()
    if options.invalid is not None:
        z[marked(z, options.invalid)] = np.nan
    if options.despike:
        there = np.flatnonzero(np.isfinite(z))
        rows = there[spikes(z[there], both=True)]
        z[rows] = np.nan
        where = f", the first in {found.row(int(rows[0]))}" if rows.size else ""
        told = [f"{counted(rows.size, 'value')} that stood out as spikes{where}, taken for missing"]
    gone = np.isnan(values).any(axis=1)
    if gone.any() and (how == "refuse" or (how == "drop" and alone)):
        seen = f"{found.row(int(gone.argmax()))}: a value is missing, and {int(gone.sum())} of {z.size} in all"
        allowed = "no missing values, or missing interpolate, or missing drop if the file has positions"
        raise ValueError(f"{seen}; allowed: {allowed}")
    there = np.flatnonzero(~np.isnan(z))
    if there.size < _FEWEST:
        raise ValueError(f"it holds {counted(there.size, 'value')}; allowed: at least {_FEWEST}")
    columns.check_values(found._replace(values=values))
    doubts, up = list[str](), -1.0 if options.profile_convention == "gap" else 1.0
    for rows, reason in doubtful(up * z[there], options.despike):
        first = int(there[rows[0]])
        doubts.append(f"{rows.size} of {z.size} values, the first {z[first]:g} in {found.row(first)}, {reason}")
    if z.size - there.size > DOUBTED * z.size:
        doubts.append(f"{z.size - there.size} of {z.size} values were missing")
    values, done = filled(values, how)
    return found._replace(values=values), told + [done] * bool(done), doubts


def _measured(found: Table, options: Options) -> tuple[Profile, dict[str, str]]:
    """The values at even spacing in the scene's unit of length, and the units of the file. Raises `ValueError`."""
    length, alone = options.scan_length, found.values.shape[1] == 1
    if alone and options.x_unit:
        raise ValueError(f"x_unit is {options.x_unit}; allowed: none, the file has no positions (give scan_length)")
    if alone and length is None:
        seen = f"the file holds {counted(len(found.values), 'height')} and no positions"
        allowed = "its length with the unit, like 1.5mm, or a number alone in the scene's unit"
        raise ValueError(f"scan_length is missing: {seen}; allowed: {allowed}")
    if not alone and length is not None:
        raise ValueError(f"scan_length is {length}; allowed: none, the file has positions")
    unknown = (options.length_unit or SCENE) if options.scene_units else None
    units = columns.units(found, {"x": options.x_unit, "z": options.z_unit}, unknown)
    scene = {SCENE: 1.0} | {unit: size / UNITS[options.length_unit or _DEFAULT] for unit, size in UNITS.items()}
    measured = [values * scene[units[axis]] for axis, values in zip(units, found.values.T, strict=True)]
    if length is None:
        return evenly_spaced(*measured), units
    return Profile(measured[0], checks.real("scan_length", length, "a finite length > 0", 0)), units


def _statistics(profile: Profile) -> dict[str, float]:
    """Lengths that tell whether a scan was understood, and the rms slope (dimensionless), about the mean line."""
    i = np.arange(profile.z.size)
    straight = profile.z - np.polynomial.Polynomial.fit(i, profile.z, 1)(i)
    height, slope = (float(np.sqrt(np.mean(z**2))) for z in (straight, np.diff(straight) / profile.spacing))
    sizes = {"scan_length": profile.length, "spacing": profile.spacing, "rms_height": height, "rms_slope": slope}
    return {f"profile_{name}": size for name, size in sizes.items()}


def _choose_grid(options: Options, values: int, in_period: int) -> int:
    """The number of grid points. Raises `ValueError`."""
    most, n = MAX_REFINEMENT * values, options.num_points
    if n is None and options.accuracy is not None:
        n = next(n for n in range(min(most, MAX_POINTS), 0, -1) if n % 2 == 0 and next_fast_len(n) == n)
    elif n is None:
        n = 2 ** math.ceil(math.log2(min(_POINTS_PER_VALUE * in_period, max(_ENOUGH, in_period))))
    n = checks.integer("num_points", n, f"an integer from {MIN_POINTS} to {MAX_POINTS}", MIN_POINTS, MAX_POINTS)
    if n > most:
        raise ValueError(f"num_points is {n}; allowed: up to {most}, {MAX_REFINEMENT} for each value in the file")
    return n
