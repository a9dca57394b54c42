"""From a file to an indenter: units that are known or asked for, and a scan that is made periodic.

Nothing is guessed: a file without units, without positions, or with more columns than it explains, is refused with
what to add. Every step goes into the result.
"""

import math
import os
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, NamedTuple, get_args

import numpy as np
from linecontact.solver import ElasticLayer, MeasuredIndenter, Scene, checks
from linecontact.solver.display import counted
from linecontact.solver.scene import MAX_POINTS, MIN_POINTS
from linecontact.solver.strategy.errors import DEFAULT_QUANTITY
from linecontact.solver.strategy.to_accuracy import check_accuracy
from linecontact.solver.units import SCENE, length_unit

from ..files.writing import as_path
from ..terminal.options import refused
from . import columns
from .columns import MAX_REFINEMENT
from .preparation import Detrend, Profile, Window, evenly_spaced, may_be_missing
from .text import Decimal
from .units import UNITS, Unit

_POINTS_PER_VALUE, _ENOUGH = 4, 2**18
"""Of the default grid, as long as it has no more points than that: contact edges lie between values."""


Convention = Literal["heights", "gap"]

_WORDS = {
    "x_unit": Unit,
    "z_unit": Unit,
    "length_unit": Unit,
    "decimal": Decimal,
    "profile_convention": Convention,
    "detrend": Detrend,
    "window": Window,
}
"""The options that are one of a few words."""


@dataclass(frozen=True)
class Options:
    """A scan or another profile from a file. Its length is the period, with its mirror image half of it."""

    profile_file: Path
    """The file: text (.csv, .txt, .dat, .asc, .tsv), .npy, .h5, or an instrument's format."""
    num_points: int | None = None
    """Grid points, up to 16 for each value; default: a power of two, at least four for each value of the period, but
    beyond 2^18 points one; with an accuracy the largest that is allowed."""
    x_unit: Unit | None = None
    """Unit of the positions, where the file names none."""
    z_unit: Unit | None = None
    """Unit of the heights, where the file names none."""
    scene_units: bool = False
    """Numbers for which no unit is known are in the scene's own unit of length, which --length-unit may name."""
    length_unit: Unit | None = None
    """The scene's own unit, of results and of lengths that are written without one; default: m. Where it is not given,
    lengths are written with their units, like 2mm, or with --scene-units as numbers alone."""
    scan_length: float | None = None
    """Length of a scan without positions [length], its spacing times its number of values."""
    columns: str | None = None
    """Columns of x and z, counted from 1, like 2,3; or of z alone, like 3."""
    decimal: Decimal | None = None
    """Decimal sign of a text, where the file leaves it open."""
    profile_convention: Convention | None = None
    """Heights have their peaks up, as a scan has them; gap is h, the distance of the indenter. Default: heights."""
    profile_dataset: str | None = None
    """Name of the dataset in an .h5 file that holds several."""
    detrend: Detrend | None = None
    """What is removed of the tilt; default: linear, but none with --window none."""
    window: Window = "mirror"
    """What makes the profile periodic: its mirror image, a window, or nothing if it is periodic."""
    period: float | None = refused()
    """Not with a file."""
    accuracy: float | None = None
    """Relative error wanted of a_r (dimensionless); it chooses the grid."""

    def __post_init__(self) -> None:
        """What the command line makes sure of, for those who come from Python. Raises `ValueError`."""
        if not isinstance(self.profile_file, Path):
            raise ValueError(f"profile_file is {self.profile_file!r}; allowed: a path")
        for name, allowed in _WORDS.items():
            if getattr(self, name) is not None or name == "window":
                checks.choice(name, getattr(self, name), get_args(allowed))
        if not isinstance(self.scene_units, bool):
            raise ValueError(f"scene_units is {self.scene_units!r}; allowed: True or False")
        for name in ("columns", "profile_dataset"):
            if not isinstance(getattr(self, name), str | None):
                raise ValueError(f"{name} is {getattr(self, name)!r}; allowed: text, like '2,3'")
        check_accuracy(self.accuracy, DEFAULT_QUANTITY)


def own_unit(length_unit: Unit | None) -> Unit:
    """The unit that the lengths of a scan's scene are in, if they have one. length_unit: the user's."""
    return length_unit or "m"


class Scan(NamedTuple):
    """A scan as an indenter, with the period and the grid that a `Scene` of it needs."""

    indenter: MeasuredIndenter
    """The indenter; its `description` holds what is known of the scan."""
    period: float
    """Period of the scene [length]."""
    num_points: int
    """Grid points of the scene."""

    def __repr__(self) -> str:
        unit = length_unit(self.indenter.description)
        return (
            f"{type(self).__name__}: period {self.period:.6g} [{unit}], num_points {self.num_points}; {self.indenter}"
        )

    def scene(self, layer: ElasticLayer, pressure: float | None = None, approach: float | None = None) -> Scene:
        """The scan pressed against a layer, by a mean pressure [pressure] or to an approach [length].

        Lengths are in the same unit as the scan's. Raises `ValueError`.
        """
        if pressure is None and approach is None:
            raise ValueError("pressure (or approach) is missing; allowed: one of the two, in the units of the layer")
        if getattr(layer, "has_default_modulus", False):  # else `Scene` says that it is no layer
            allowed = "its E* must be given, in one unit with the pressure, because lengths have units"
            raise ValueError(f"contact_modulus of the layer is missing; allowed: {allowed}")
        load = math.nan if pressure is None else pressure
        return Scene(layer, self.indenter, load, self.period, self.num_points, approach=approach)


def read_scan(path: str | os.PathLike[str], **options: Any) -> Scan:
    """Read a scan from a file: indenter, period and number of grid points, which a `Scene` takes.

    path: the file. options: as the fields of `Options` say, for instance `x_unit="um"`, `z_unit="nm"`,
    `scan_length=1e-3`, `num_points=2**14`. Lengths of the scene are in metres unless `length_unit` says otherwise.

    Raises `ValueError` for a file that cannot be read, whose units are not known, or that is no profile; it says what
    to add.
    """
    allowed = [field.name for field in fields(Options) if field.name not in ("profile_file", "period")]
    for name in options:
        if name not in (*allowed, "period"):
            raise ValueError(f"option is {name!r}; allowed: {', '.join(allowed)}")
    return read(Options(as_path("path", path), **options))


def read(options: Options) -> Scan:
    """As `read_scan`."""
    path = options.profile_file
    if not os.path.isfile(path):  # Path's own raises for some names
        raise ValueError(f"profile_file is {path}, which is not a file; allowed: an existing file")
    if options.period is not None:
        raise ValueError(
            f"period is {options.period}; allowed: none with a file, whose scan is the period, with its mirror image "
            "half of it (scan_length is for files without positions)"
        )
    try:
        found = columns.load(path, options.profile_dataset, options.columns, options.decimal)
    except (OSError, EOFError, UnicodeError) as error:
        raise ValueError(f"profile_file {path} cannot be read: {error}") from None
    profile, units = _measured(found, options)
    if (odd := may_be_missing(found.z)).size:
        unit = units["profile_z_unit"].replace(SCENE, "")
        profile.doubts.append(
            f"{odd.size} of {counted(found.z.size, 'value')}, the first is {found.z[odd[0]]:g} {unit}".rstrip()
            + f" in row {odd[0] + 1}, lie far from all others; leave out what stands for missing values"
        )
    count, scan = profile.z.size, _statistics(profile)
    _turn_over(profile, found, options)
    height = np.ptp(profile.z)
    profile.detrend(options.detrend or ("none" if options.window == "none" else "linear"))
    if np.ptp(profile.z) <= 1e-12 * height:
        raise ValueError(f"profile_file {path} holds a straight line; allowed: a profile that is not")
    profile.make_periodic(options.window)
    measured = profile.z.size
    n = _choose_grid(options, count, measured)
    profile.resample(n, mirrored=options.window == "mirror")
    known = set(units.values()) - {SCENE}
    description = {
        "profile_file": columns.shown_name(path),
        "profile_convention": options.profile_convention or "heights",
        "profile_values": count,
        **units,
        "profile_length_unit": own_unit(options.length_unit) if known else SCENE,
        **scan,
        **({"profile_doubts": "; ".join(profile.doubts)} if profile.doubts else {}),
        "profile_steps": "; ".join([found.origin, *profile.steps, "shifted to h >= 0"]),
    }
    return Scan(MeasuredIndenter(profile.z, measured, description, profile.length), profile.length, n)


def _measured(found: columns.Columns, options: Options) -> tuple[Profile, dict[str, str]]:
    """The values at even spacing in the scene's unit of length, and the units of the file. Raises `ValueError`."""
    path, x, z = options.profile_file, found.x, found.z
    length = _given_length(options, z.size) if x is None else 0.0
    named = {"z": found.z_units} if x is None else {"x": found.x_units, "z": found.z_units}
    unknown = (options.length_unit or SCENE) if options.scene_units else None
    units = columns.units(path, named, {"x": options.x_unit, "z": options.z_unit}, unknown, found.unread)
    own = UNITS[own_unit(options.length_unit)]
    scene = {SCENE: 1.0} | {unit: size / own for unit, size in UNITS.items()}
    described = {f"profile_{axis}_unit": unit for axis, unit in units.items()}
    if x is None:
        columns.check_values(path, None, z)
        return Profile(z * scene[units["z"]], length), described
    if options.scan_length is not None:
        raise ValueError(f"scan_length is {options.scan_length}; allowed: none, {path} has positions")
    _check_no_count(found, options)
    turned = x[-1] < x[0]
    x, z = (x[::-1], z[::-1]) if turned else (x, z)
    columns.check_values(path, x, z)
    try:
        profile = evenly_spaced(x * scene[units["x"]], z * scene[units["z"]])
    except ValueError as error:
        raise ValueError(f"profile_file {path}: {error}; cut or fill it") from None
    if turned:
        profile.steps.insert(0, "positions decrease: read from the end")
    return profile, described


def _check_no_count(found: columns.Columns, options: Options) -> None:
    """Raise `ValueError` for positions 0, 1, 2, ... whose unit stands neither at their column nor in an option."""
    x = found.x
    asked = options.x_unit or options.scene_units or not any(w.startswith("the line") for w in found.x_units.values())
    if x is not None and not asked and np.array_equal(x, np.round(x)) and np.ptp(np.diff(x)) == 0:
        raise ValueError(
            f"x_unit is missing: {options.profile_file} has positions {x[0]:g}, {x[1]:g}, ..., which may count the "
            "values; allowed: their unit, or columns of the heights alone and scan_length"
        )


def _given_length(options: Options, count: int) -> float:
    """The length of a scan without positions [length]. Raises `ValueError` where it is not given."""
    path = options.profile_file
    if options.x_unit:
        raise ValueError(f"x_unit is {options.x_unit}; allowed: none, {path} has no positions (give scan_length)")
    if options.scan_length is None:
        own = f"the scene's unit (length_unit, {own_unit(options.length_unit)})"
        allowed = f"on the command line with its unit, like 1.5mm, else in {own}"
        if options.scene_units and options.length_unit is None:
            allowed = "a number alone in the scene's unit, or with a unit, like 1.5mm, if length_unit says that one"
        raise ValueError(
            f"scan_length is missing: {path} holds {counted(count, 'height')} and no positions; allowed: its length, "
            f"{allowed}"
        )
    return checks.real("scan_length", options.scan_length, "a finite length > 0", 0)


def _statistics(profile: Profile) -> dict[str, float]:
    """What tells whether a scan was understood, in the scene's unit; rms height and slope are about the mean line."""
    i = np.arange(profile.z.size) - (profile.z.size - 1) / 2
    straight = profile.z - profile.z.mean()
    straight = straight - float(i @ straight) / float(i @ i) * i
    return {
        "profile_scan_length": profile.length,
        "profile_spacing": profile.spacing,
        "profile_rms_height": float(np.sqrt(np.mean(straight**2))),
        "profile_rms_slope": float(np.sqrt(np.mean(np.diff(straight) ** 2))) / profile.spacing,
    }


def _turn_over(profile: Profile, found: columns.Columns, options: Options) -> None:
    """Make h of heights, unless the file holds h."""
    if options.profile_convention is None and found.is_depth:
        raise ValueError(
            f"profile_convention is missing: {options.profile_file} speaks of depths or gaps; allowed: heights, if its "
            "values grow towards the peaks, or gap, if they grow into the valleys"
        )
    if options.profile_convention != "gap":
        profile.z = -profile.z
        profile.steps.append("heights turned over: peaks up become the indenter's lowest points")


def _is_fast(num_points: int) -> bool:
    """Whether it is even, and a product of 2, 3 and 5, which transforms take quickly."""
    for prime in (2, 3, 5) if num_points % 2 == 0 else ():
        while num_points % prime == 0:
            num_points //= prime
    return num_points == 1


def _choose_grid(options: Options, values: int, in_period: int) -> int:
    """The number of grid points. Raises `ValueError`."""
    most = MAX_REFINEMENT * values
    n = options.num_points
    if n is None and options.accuracy is not None:
        n = next(n for n in range(min(most, MAX_POINTS), 0, -1) if _is_fast(n))
    elif n is None:
        fine = min(_POINTS_PER_VALUE * in_period, max(_ENOUGH, in_period))
        n = 2 ** math.ceil(math.log2(fine))
    n = checks.integer("num_points", n, f"an integer from {MIN_POINTS} to {MAX_POINTS}", MIN_POINTS, MAX_POINTS)
    if n > most:
        raise ValueError(
            f"num_points is {n}; allowed: up to {MAX_REFINEMENT} times the {values} values in {options.profile_file}"
        )
    return n
