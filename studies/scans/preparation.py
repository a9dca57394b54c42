"""From the heights of a scan to a periodic profile on a grid. Every step is told in words."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from linecontact.solver.arrays import Array64, Indices
from linecontact.solver.transforms.plain import irfft, rfft

Detrend = Literal["linear", "mean", "none"]
Window = Literal["mirror", "tukey", "hann", "none"]

_TAPER = 0.1  # share of the length over which a Tukey window falls, at each end
_ROUNDING = 0.6  # of the positions' last digit: by how much rounding puts them off
_ROUNDED = 0.9  # spacings that the last digit may be worth: one spacing is a value left out
_EVEN = 0.01  # spacings by which positions may be off without that
_LONGEST_GAP = 0.05  # share of the scan that may be without values
_DOUBTED = 0.01  # share of the scan that may be filled without a warning
_SPARSE = 1.1  # places for each value, up to which the others are taken for missing ones
_COARSE = 0.3  # spacings: with a last digit worth more, single steps do not tell how many places they are
_TIMES = 5  # that the spacing is made better
_UNEVEN = 0.05  # relative difference of a step from the mean, from which there is a warning
_GAP = 1.8  # spacings from which values are missing
_JUMP = 2.0  # from the last value to the first, over the largest step between neighbours
_FAR = 10.0  # times as far from the median as nine in ten values
_SUDDEN = 0.8  # of that distance, covered by one step: no peak or valley of a surface looks like that
_MIRROR = "made periodic by its mirror image"


@dataclass
class Profile:
    """A profile while it is made periodic."""

    z: Array64
    """Heights or gaps, shape (number of values,) [length]."""
    length: float
    """Their number times their spacing [length]."""
    steps: list[str] = field(default_factory=list)
    """What has been done, in words."""
    doubts: list[str] = field(default_factory=list)
    """What of it may be wrong, in words."""

    @property
    def spacing(self) -> float:
        """Distance of two values [length]."""
        return self.length / self.z.size

    def detrend(self, how: Detrend) -> None:
        """Remove the mean, or a straight line by least squares."""
        if how == "linear":
            i = np.arange(self.z.size) - (self.z.size - 1) / 2
            slope = float(i @ self.z) / float(i @ i)
            self.steps.append(f"tilt of {slope / self.spacing:.4g} (dimensionless) removed by least squares")
            self.z = self.z - slope * i
        if how != "none":
            self.steps.append("mean removed")
            self.z = self.z - self.z.mean()

    def make_periodic(self, window: Window) -> None:
        """Let the ends meet, by the mirror image, which doubles the length but keeps the roughness, or by a window.

        A window smooths the ends away, which then touch nearly everywhere and add to the contact area.
        """
        if window == "mirror":
            self.steps.append(f"{_MIRROR}: the period is twice the scan")
            self.z, self.length = np.concatenate([self.z, self.z[::-1]]), 2 * self.length
        elif window == "none":
            self.steps.append("taken as periodic: the last value meets the first")
            jump, largest = abs(float(self.z[0] - self.z[-1])), float(np.abs(np.diff(self.z)).max())
            if jump > _JUMP * largest:
                self.doubts.append(
                    f"from the last value of the scan to the first, which it meets, is a step {round(jump / largest)} "
                    "times as high as any in the scan: it does not look periodic (window)"
                )
        else:
            taper = 0.5 if window == "hann" else _TAPER
            z = self.z - self.z.mean()
            ramp = np.minimum(np.arange(z.size) + 0.5, z.size - 0.5 - np.arange(z.size)) / (taper * z.size)
            self.z = z * np.sin(np.pi / 2 * np.minimum(ramp, 1.0)) ** 2
            self.steps.append(
                f"made periodic by a {window} window: the period is the scan; heights fall to the mean over "
                f"{taper:g} of it at each end, whose roughness is lost and which may touch nearly everywhere"
            )

    def resample(self, num_points: int, mirrored: bool) -> None:
        """The Fourier modes on another number of points; mirrored: keep the axes of a mirror image between two."""
        count = self.z.size
        if count == num_points:
            return
        self.steps.append(f"resampled from {count} to {num_points} points by Fourier modes")
        modes = rfft(self.z)
        held = (min(num_points, count) + 1) // 2  # all but an unpaired highest mode
        modes[held:] = 0
        if mirrored:
            modes *= np.exp(1j * np.pi * np.arange(modes.size) * (1 / num_points - 1 / count))
        z = irfft(modes[: held + 1], num_points) * (num_points / count)
        self.z = (z + z[::-1]) / 2 if mirrored else z  # even to the last bit


def mirrored(about: Mapping[str, Any]) -> bool:
    """Whether the second half of the period is the mirror image of a scan, whose contact patches then count twice.

    about: what travels with a scan's results, see `MeasuredIndenter.description`.
    """
    return _MIRROR in str(about.get("profile_steps", ""))


def evenly_spaced(x: Array64, z: Array64) -> Profile:
    """A profile from heights at increasing positions, shape (number of values,) each [length].

    Positions that are even but for the rounding of their digits, to less than their spacing, are taken as even. So are
    those of which some are missing, whose heights are filled. Others are interpolated. The length of the scan is one
    spacing for each place. Raises `ValueError` for a gap that is too long for that.
    """
    x = x - x[0]
    spacing, off = _spacing(x, np.arange(x.size))
    digit = _last_digit(x)

    def even(off: float, spacing: float) -> bool:
        return off <= max(_EVEN * spacing, _ROUNDING * digit if digit < _ROUNDED * spacing else 0.0)

    if even(off, spacing):
        return Profile(z, spacing * x.size, [f"positions even to {off / spacing:.2g} of their spacing, taken as even"])
    steps = np.diff(x)
    gap = float(steps.max())
    if gap > _LONGEST_GAP * x[-1] and gap > 1.5 * spacing:
        raise ValueError(f"x has a gap of {gap / x[-1]:.1%} of the scan; allowed: up to {_LONGEST_GAP:.0%}")
    place = _places(steps)
    spacing, off = _spacing(x, place)
    count = int(place[-1]) + 1
    coarse = _COARSE < digit / spacing < _ROUNDED
    doubts = []
    if even(off, spacing) and count <= _SPARSE * x.size and not coarse:
        missing, even_x = count - x.size, np.arange(count)
        told = f"positions even to {off / spacing:.2g} of their spacing, {missing} missing, "
        told += "whose heights were filled by straight lines"
        place_x, filled = place.astype(np.float64), missing / count
    else:
        spacing, even_x, place_x = float(x[-1]) / (x.size - 1), np.arange(x.size), x / x[-1] * (x.size - 1)
        told = f"interpolated linearly to even spacing, the largest gap {gap / spacing:.3g} spacings"
        filled = float((steps[steps > _GAP * np.median(steps)]).sum() / x[-1])
        usual = steps[steps <= _GAP * np.median(steps)]
        uneven = float(np.abs(usual / usual.mean() - 1).max())
        if uneven > _UNEVEN and digit < _ROUNDED * spacing:
            apart = f"steps between positions differ from their mean by up to {uneven:.0%}"
            doubts = [f"{apart}; heights were interpolated by straight lines, which flattens short waves"]
    if filled > _DOUBTED:
        doubts.append(f"{filled:.1%} of the scan, where it has no values, were filled by straight lines")
    return Profile(np.asarray(np.interp(even_x, place_x, z)), spacing * even_x.size, [told], doubts)


def _places(steps: Array64) -> Indices:
    """The places of positions in a row of even ones of which few are missing, shape (number of values,).

    steps: from one position to the next, rounded like them, shape (number of values - 1,) [length].
    """
    spacing = float(steps.mean())  # too large by the share of those that are missing
    for _ in range(_TIMES):
        away = np.maximum(np.rint(steps / spacing), 1.0)
        spacing = float(steps.sum() / away.sum())
    return np.cumsum(np.concatenate([[0.0], away])).astype(np.int64)


def _spacing(x: Array64, place: Indices) -> tuple[float, float]:
    """The spacing of positions at these places of a row, by least squares, and by how much one is off at most."""
    i = place - place.mean()
    spacing = float(i @ x) / float(i @ i)
    return spacing, float(np.abs(x - x.mean() - spacing * i).max())


def may_be_missing(z: Array64) -> Indices:
    """Which heights may stand for missing values, like -9999: one or two numbers, in up to a tenth of the scan, far
    from all others and from one value to the next; or what begins the scan, like the number of its values.

    z: shape (number of values,) [any unit].
    """
    steps = np.diff(z)
    level = z - np.median(steps) * np.arange(z.size)
    away = np.abs(level - np.median(level))
    usual = max(float(np.quantile(away, 0.9)), float(np.abs(steps[steps != 0]).min(initial=np.inf)))
    far = np.concatenate([[False], away > _FAR * usual, [False]])
    first, last = np.flatnonzero(np.diff(far.astype(int)) > 0), np.flatnonzero(np.diff(far.astype(int)) < 0) - 1
    runs = [
        np.arange(a, b + 1)
        for a, b in zip(first, last, strict=True)
        if _is_sudden(z, away, int(a), -1) and _is_sudden(z, away, int(b), 1)
    ]
    found = np.concatenate([np.zeros(0, dtype=np.int64), *runs])
    if np.unique(z[found]).size <= 2:
        return found
    return found[: int(found[0] == 0 and found[1] != 1)]  # the first value, if it stands alone


def _is_sudden(z: Array64, away: Array64, inside: int, side: int) -> bool:
    """Whether the step from a far value to its neighbour is most of the way back; True at the end of the scan."""
    outside = inside + side
    return not 0 <= outside < z.size or abs(float(z[inside] - z[outside])) > _SUDDEN * away[inside]


def _last_digit(x: Array64) -> float:
    """The value of the last digit of rounded positions, whose distances are multiples of it."""
    distances = np.unique(np.round(np.diff(x) / x[-1], 12))
    return float(np.diff(distances).min(initial=distances[0]) * x[-1]) if distances.size > 1 else 0.0
