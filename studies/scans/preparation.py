"""From the heights of a scan to a periodic profile on a grid. Every step is told in words."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from linecontact.solver.arrays import Array64
from linecontact.solver.transforms.plain import irfft, rfft

from .missing import DOUBTED, LONGEST_GAP

Detrend = Literal["curvature", "linear", "mean", "none"]
Window = Literal["mirror", "none"]

_ROUNDING = 0.6  # of the positions' last digit: by how much rounding puts them off
_ROUNDED = 0.9  # spacings that the last digit may be worth: one spacing is a value left out
_EVEN = 0.01  # spacings by which positions may be off without that
_COARSE = 0.3  # spacings: with a last digit worth more, single steps do not tell how many places they are
_UNEVEN = 0.05  # relative difference of a step from the mean, from which there is a warning
_GAP = 1.8  # spacings from which values are missing
_JUMP = 2.0  # from the last value to the first, over the largest step between neighbours
_FORM, _BEND = 5.0, 8.0  # rms heights of the rest, above which a bow or an S is doubted: some waves are like one
_ROOM = 0.25  # of the second difference, that waves may pass the values on both sides: twice a parabola's
_BETWEEN = 0.25  # rms heights that waves may pass them without a doubt
_EXACT = 1e-9  # of the height, in Fourier modes
_MIRROR = "made periodic by its mirror image"


@dataclass
class Profile:
    """A profile while it is made periodic."""

    z: Array64  # heights or gaps, shape (number of values,) [length]
    length: float  # their number times their spacing [length]
    steps: list[str] = field(default_factory=list)  # that were taken, in words
    doubts: list[str] = field(default_factory=list)  # about them, in words

    @property
    def spacing(self) -> float:
        """Distance of two values [length]."""
        return self.length / self.z.size

    def detrend(self, how: Detrend | None) -> None:
        """Remove the mean, a straight line or a parabola by least squares; None: a line, and form is doubted."""
        degree = {"none": -1, "mean": 0, "curvature": 2}.get(how or "", 1)
        i, legendre = np.linspace(-1.0, 1.0, self.z.size), np.polynomial.legendre
        fitted, form = (legendre.legfit(i, self.z, degree) for degree in (2, 3))
        rest = float((self.z - legendre.legval(i, form)).std())
        heights = (float(np.ptp(legendre.legval(i, form * (np.arange(4) == n)))) for n in (2, 3))
        bow, bend = (height / rest if rest else math.inf for height in heights)
        if degree > 0:
            slope = 2 * fitted[1] / (self.length - self.spacing)
            self.steps.append(f"tilt of {slope:.4g} (dimensionless) removed by least squares")
        if degree > 1:
            self.steps.append(f"bow removed by least squares (parabola, {bow:.3g} rms heights of the rest)")
        if degree >= 0:
            self.steps.append("mean removed")
            self.z = self.z - legendre.legval(i, fitted[: degree + 1])
        kept = "times the rms height of the rest was kept and may carry the load"
        if how is None and _FORM < bow < math.inf:
            self.doubts.append(f"a bow of {bow:.3g} {kept}: detrend curvature removes it, linear says that it is meant")
        if how in (None, "curvature") and _BEND < bend < math.inf:
            self.doubts.append(f"an S-shaped form of {bend:.3g} {kept}: detrend does not remove it")

    def make_periodic(self, window: Window) -> None:
        """Let the ends meet by the mirror image, which doubles the length and keeps the roughness, if they do not."""
        if window == "mirror":
            self.steps.append(f"{_MIRROR}: the period is twice the scan")
            self.z, self.length = np.concatenate([self.z, self.z[::-1]]), 2 * self.length
        else:
            self.steps.append("taken as periodic: the last value meets the first")
            jump, largest = abs(float(self.z[0] - self.z[-1])), float(np.abs(np.diff(self.z)).max())
            if jump > _JUMP * largest:
                step = f"a step {round(jump / largest)} times as high as any in the scan"
                self.doubts.append(f"from the last value to the first is {step}: it does not look periodic (window)")

    def resample(self, num_points: int) -> None:
        """The profile on another number of points by its Fourier modes, or straight lines where waves overshoot.

        Between two values waves may leave the straight line by `_ROOM` of the larger second difference there, and pass
        the values by that of the smaller one if both bend one way: a parabola does by an eighth, beside a step nothing.
        """
        z, count = self.z, self.z.size
        if count == num_points:
            return
        modes = rfft(z)[: num_points // 2 + 1]
        if min(num_points, count) % 2 == 0:
            modes[-1] *= 0.5 * (num_points > count)  # an unpaired one
        waves = irfft(modes, num_points) * (num_points / count)
        self.steps.append(f"resampled from {count} to {num_points} points by Fourier modes")
        if num_points > count:
            at = np.arange(num_points) * (count / num_points)
            straight, i, after = np.interp(at, np.arange(count + 1), np.append(z, z[0])), at.astype(int), np.roll(z, -1)
            bend = after - 2 * z + np.roll(z, 1)
            less, more = _ROOM * np.sort(np.abs([bend, np.roll(bend, -1)]), axis=0)
            beyond = np.maximum(np.minimum(z, after)[i] - waves, waves - np.maximum(z, after)[i])
            apart = np.maximum(np.abs(waves - straight) - more[i], beyond - (less * (bend * np.roll(bend, -1) > 0))[i])
            replaced = (np.bincount(i, apart > _EXACT * np.ptp(z), count) > 0)[i]
            above = float(np.max((np.minimum(z, after)[i] - waves)[replaced], initial=0.0) / z.std())
            self.steps.append(f"straight lines in {replaced.mean():.0%} of the scan, where modes would overshoot")
            if above > _BETWEEN:  # of h, whose summits are its lowest points
                seen = f"between its values, waves would rise up to {above:.2g} rms heights above them"
                self.doubts.append(f"{seen}: straight lines were taken, the scan does not resolve its steps or summits")
            waves = np.where(replaced, straight, waves)
        self.z = waves


def mirrored(about: Mapping[str, Any]) -> bool:
    """Whether half of the period is the mirror image of the scan with this `MeasuredIndenter.description`."""
    return _MIRROR in str(about.get("profile_steps", ""))


def evenly_spaced(x: Array64, z: Array64) -> Profile:
    """A profile from heights at positions that go one way, shape (number of values,) each [length].

    Positions that are even except for the rounding of their digits are taken as even, also where some are missing,
    whose heights are filled. Others are interpolated. Raises `ValueError` for a gap that is too long for that.
    """
    told, doubts = ["positions decrease: read from the end"] * bool(x[-1] < x[0]), list[str]()
    x, z = (x[::-1] - x[-1], z[::-1]) if told else (x - x[0], z)
    steps, digit, mean = np.diff(x), _last_digit(x), float(x[-1]) / (x.size - 1)
    rounding = digit if digit < _ROUNDED * mean else 0.0
    long, gap = steps > _GAP * np.median(steps), float(steps.max())
    place = np.arange(x.size, dtype=np.float64)
    if rounding <= _COARSE * mean:
        usual = max(float(steps[~long].mean()), mean / 2)  # else more are missing than there
        place[1:] = np.cumsum(np.maximum(np.rint(steps / usual), 1.0))
    i = place - place.mean()
    spacing = float(i @ x) / float(i @ i)
    off = float(np.abs(x - x.mean() - spacing * i).max()) / spacing
    even = off <= max(_EVEN, _ROUNDING * rounding / spacing)
    count = int(place[-1]) + 1 if even else x.size
    if even and count == x.size:
        return Profile(z, spacing * count, [*told, f"positions even to {off:.2g} of their spacing, taken as even"])
    if gap > max(LONGEST_GAP * x[-1], 1.5 * spacing):
        seen = f"x has a gap of {gap / x[-1]:.1%} of the scan"
        raise ValueError(f"{seen}; allowed: up to {LONGEST_GAP:.0%}; cut or fill it")
    if even:
        told.append(f"positions even to {off:.2g} spacings, {count - x.size} missing, whose heights were filled")
    else:
        spacing, place = mean, x / mean
        told.append(f"interpolated linearly to even spacing, the largest gap {gap / spacing:.3g} spacings")
        uneven = float(np.abs(steps[~long] / steps[~long].mean() - 1).max())
        if uneven > _UNEVEN and digit == rounding:
            apart = f"steps between positions differ from their mean by up to {uneven:.0%}"
            doubts.append(f"{apart}; heights were interpolated by straight lines, which flattens short waves")
    empty = float((steps[long] - np.median(steps)).sum() / x[-1])
    if empty > DOUBTED:
        doubts.append(f"{empty:.1%} of the scan, where it has no values, were filled by straight lines")
    return Profile(np.asarray(np.interp(np.arange(count), place, z)), spacing * count, told, doubts)


def _last_digit(x: Array64) -> float:
    """The value of the last digit of rounded positions, whose distances are multiples of it."""
    distances = np.unique(np.round(np.diff(x) / x[-1], 12))
    return float(np.diff(distances).min(initial=distances[0]) * x[-1]) if distances.size > 1 else 0.0
