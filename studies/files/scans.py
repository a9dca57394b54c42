"""Indenters from profile files: what makes a measured scan a periodic indenter on a grid.

A file with exactly as many values as the grid has points is taken as it is, but for the shift to h >= 0. Any other is
resampled, and before that, unless told otherwise, freed of its tilt and made periodic. Every step goes into the result.
"""

import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from linecontact.solver import MeasuredIndenter, checks
from linecontact.solver.scene import MAX_POINTS, MIN_POINTS
from numpy.typing import NDArray

from . import profile_columns
from .profile_columns import MAX_REFINEMENT, UNITS, Unit

Array64 = NDArray[np.float64]

_TAPER = 0.1  # share of the length over which a Tukey window falls, at each end

Detrend = Literal["auto", "none", "mean", "linear"]
Window = Literal["auto", "none", "tukey", "hann", "mirror"]


@dataclass(frozen=True)
class Options:
    """How to read a profile from a file."""

    profile_file: Path
    """The file: .npy, text of one or two columns, .h5, or an instrument's format."""
    num_points: int | None = None
    """Grid points; default: the next power of two."""
    period: float | None = None
    """Period [length] of a file without positions; default: 1."""
    profile_convention: Literal["gap", "heights"] = "gap"
    """Whether the file holds h, the distance of the indenter, or heights as a scan has them, peaks up."""
    profile_dataset: str | None = None
    """Name of the dataset in an .h5 file that holds several."""
    x_unit: Unit | None = None
    """Unit of the positions; default: the scene's unit of length."""
    z_unit: Unit | None = None
    """Unit of the heights; default: the scene's unit of length."""
    length_unit: Unit = "m"
    """What one [length] of the scene is, where the file or an option names a unit."""
    resample: bool = False
    """Whether to treat even a file with as many values as grid points like any other."""
    detrend: Detrend = "auto"
    """What is removed of the tilt; auto: a line, or nothing from a file that is taken as it is."""
    window: Window = "auto"
    """What makes the profile periodic; auto: its mirror image, or nothing for a file that is taken as it is."""


def read(options: Options) -> tuple[MeasuredIndenter, float, int]:
    """The indenter, the period [the scene's unit of length] and the number of grid points.

    Raises `ValueError` for a file that is missing, empty, not numbers, constant, not increasing in x, too short, or too
    large, see `profile_columns`.
    """
    path = options.profile_file
    if not os.path.isfile(path):  # Path's own raises for some names
        raise ValueError(f"profile_file is {path}, which is not a file; allowed: .npy, .csv, .txt, .h5, scans")
    given = options.x_unit or options.z_unit
    try:
        x, z, origin = profile_columns.load(path, options.profile_dataset, given, options.length_unit)
    except (OSError, EOFError, UnicodeError) as error:
        raise ValueError(f"profile_file {path} cannot be read: {error}") from None
    profile_columns.check_values(path, x, z)
    x, z = _in_scene_units(x, z, options)
    count = z.size
    as_is, length, n = _choose_grid(options, count)
    steps = [origin]
    if options.profile_convention == "heights":
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
        "profile_file": profile_columns.shown_name(path),
        "profile_values": count,
        "profile_convention": options.profile_convention,
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
            f"num_points is {n}; allowed: up to {MAX_REFINEMENT} times the {count} values in {options.profile_file}"
        )
    return as_is, length, n


def _resample(z: Array64, num_points: int, mirrored: bool) -> Array64:
    modes = np.fft.rfft(z)
    held = (min(num_points, z.size) + 1) // 2  # all but an unpaired highest mode
    modes[held:] = 0
    if mirrored:  # the axes stay half-way between two points: the profile stays even
        modes *= np.exp(1j * np.pi * np.arange(modes.size) * (1 / num_points - 1 / z.size))
    z = np.fft.irfft(modes[: held + 1], num_points) * (num_points / z.size)
    return np.asarray((z + z[::-1]) / 2 if mirrored else z)  # even to the last bit: then half of the nodes will do


def _in_scene_units(x: Array64 | None, z: Array64, options: Options) -> tuple[Array64 | None, Array64]:
    """Both axes in the scene's unit of length; without a unit they are taken to be in it."""
    scene = UNITS[options.length_unit]
    if options.x_unit and x is None:
        raise ValueError(f"x_unit is {options.x_unit}; allowed: none, the file has no positions (give the period)")
    if options.x_unit and x is not None:
        x = x * (UNITS[options.x_unit] / scene)
    if options.z_unit:
        z = z * (UNITS[options.z_unit] / scene)
    return x, z


def _even(x: Array64, z: Array64, steps: list[str]) -> tuple[Array64, float]:
    """Heights at even spacing, and the length of the scan, which is one spacing for each value.

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
    """Remove the tilt and make the profile periodic, by default with its mirror image, unless it is taken as it is.

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
