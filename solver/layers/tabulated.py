"""A layer given by a table of its stiffness K(q), or by a function that makes one: graded layers, several layers,
whatever was computed elsewhere.

Between the rows ln K is a cubic in ln q, with the slopes of F. N. Fritsch and R. E. Carlson (SIAM J. Numer. Anal. 17,
238 (1980)), so it does not overshoot. Beyond the last row short waves may find a half-space, K = E* q/2, before the
first one long waves a foundation, K constant, or a half-space, if the table's ends say so; otherwise waves that it
lacks are refused.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from .. import checks, display
from ..arrays import Array64
from .layer import ElasticLayer, own_stiffness

_FEWEST = 8  # rows
CLOSE = 0.02
"""Relative difference of K from a law, or of its power of q, at which it has become that law; and the largest change of
K where every other row is left out (with all rows it is some sixteenth of that)."""
_LAWS = (0, 1, -2)  # powers of q with which K may begin
_FINE = 1e-6  # change of a function
_MOST = 2**16  # rows from which a function is not sampled more finely


@dataclass(frozen=True)
class TabulatedLayer(ElasticLayer):
    """A layer whose stiffness K(q) is given by a table.

    Raises `ValueError`.
    """

    wave_numbers: tuple[float, ...]
    """q > 0 in increasing order, eight or more [1/length]."""
    stiffnesses: tuple[float, ...]
    """K(q) > 0 [pressure/length]."""
    contact_modulus: float = field(default=math.nan)
    """E* [pressure] of p* and of kappa; default: 2 K/q of the last row."""
    source: str = ""
    """Where the table is from."""

    name: ClassVar[str] = "file"

    def __post_init__(self) -> None:
        q, k = (_column(name, getattr(self, name)) for name in ("wave_numbers", "stiffnesses"))
        if q.size != k.size:
            raise ValueError(f"stiffnesses are {k.size}; allowed: {q.size}, as many as wave_numbers")
        down = np.flatnonzero(np.diff(q) <= 0)
        if down.size:
            after = f"{q[down[0] + 1]:.6g} after {q[down[0]]:.6g}"
            raise ValueError(f"wave_numbers are {after} in row {down[0] + 2}; allowed: increasing ones")
        modulus = 2 * float(k[-1] / q[-1]) if math.isnan(self.contact_modulus) else self.contact_modulus
        checks.assign(
            self,
            wave_numbers=tuple(q.tolist()),
            stiffnesses=tuple(k.tolist()),
            contact_modulus=checks.real("contact_modulus", modulus, "a finite pressure > 0", 0),
        )
        if self._powers[0] not in _LAWS:
            slope = f"goes like q^{self._powers[0]:.2g}"
            allowed = "a table that begins where K is constant (a foundation), or goes like q (a half-space) or 1/q^2"
            raise ValueError(f"stiffnesses begin at q = {q[0]:.4g}, where K {slope}; allowed: {allowed}")
        error, about = _left_out(q, k)
        if error > CLOSE:
            change = f"{error:.0%} about q = {about:.3g}"
            allowed = f"rows so close that it is below {CLOSE:.0%}"
            raise ValueError(f"stiffnesses, where every other row is left out, change by {change}; allowed: {allowed}")

    @classmethod
    def from_function(
        cls, stiffness: Callable[[Array64], Array64], first: float, last: float, contact_modulus: float = math.nan
    ) -> Self:
        """The layer of a function K(q) [pressure/length], by a table between two wave numbers [1/length] with as many
        rows as it takes to know a smooth K to a few 1e-7. Anything narrower than the rows is not seen.

        stiffness: takes an array of wave numbers q > 0 [1/length], and returns K(q) > 0 of its shape. first, last: as
        in a table, K must have become the law of long waves at the one and of short waves at the other, or the scene
        must not have waves beyond. Raises `ValueError` for these, and for a function that returns anything else or
        changes too quickly.
        """
        first, last = (checks.real(*end, "a finite wave number > 0", 0) for end in (("first", first), ("last", last)))
        if not 2 * first <= last:
            raise ValueError(f"last is {last:g}; allowed: at least twice the first, which is {first:g}")
        count = _FEWEST * math.ceil(math.log10(last) - math.log10(first) + 1) + 1
        while True:
            count = 2 * count - 1  # an odd number, so that the last interval is examined, too
            q = np.geomspace(first, last, count)
            k = own_stiffness("stiffness(q)", "q", stiffness, q)
            error, about = _left_out(q, k)
            if error < _FINE:
                return cls(tuple(q.tolist()), tuple(k.tolist()), contact_modulus, "a function")
            if count >= _MOST:
                raise ValueError(
                    f"stiffness(q) changes by {error:.1g} about q = {about:.4g} where every other of {count} rows is "
                    f"left out; allowed: below {_FINE:g}, a function that is smoother there"
                )

    def __repr__(self) -> str:
        of = f" of {self.source}" * bool(self.source)
        span = f"{self.wave_numbers[0]:.3g} to {self.wave_numbers[-1]:.3g} [1/length]"
        modulus = f"contact_modulus {display.number(self.contact_modulus)} [pressure]"
        return f"TabulatedLayer: {len(self.wave_numbers)} rows{of}, q {span}, {modulus}"

    @property
    def thickness(self) -> float:  # type: ignore[override]
        """The length beyond which waves do not find the half-space of short waves any more [length]."""
        q, k = np.array(self.wave_numbers), np.array(self.stiffnesses)
        other = np.flatnonzero(np.abs(2 * k / (self.contact_modulus * q) - 1) > CLOSE)
        return float(1 / q[other[-1]]) if other.size else math.inf

    def check(self, period: float) -> None:
        longest, last = 2 * math.pi / period, self.wave_numbers[-1]
        if last < longest:
            raise ValueError(
                f"stiffnesses end at q = {last:.4g}, and this scene's longest wave is q = {longest:.4g}; allowed: a "
                "table that holds some of the scene's waves, in its unit of length"
            )

    def stiffness(self, wave_numbers: Array64, period: float) -> Array64:
        q = wave_numbers / period
        first, last = self.wave_numbers[0], self.wave_numbers[-1]
        low, high = self._powers
        if float(q.min()) < first * (1 - 1e-12) and low < 0:
            raise ValueError(_missing("long", float(q.min()), first, "foundation or half-space"))
        if float(q.max()) > last * (1 + 1e-12) and abs(high - 1) >= CLOSE:
            raise ValueError(_missing("short", float(q.max()), last, "half-space"))
        inside = np.clip(q, first, last)
        values = np.exp(_cubic(np.log(self.wave_numbers), np.log(self.stiffnesses), np.log(inside)))
        values *= np.minimum(q / first, 1.0) ** max(low, 0) * np.maximum(q / last, 1.0)
        return np.asarray(values * period / self.contact_modulus)

    @property
    def _powers(self) -> tuple[float, float]:
        """The powers of q with which K begins, 0, 1 or -2 where it is close to one of them, and ends."""
        q, k = (np.diff(np.log(values))[[0, -1]] for values in (self.wave_numbers, self.stiffnesses))
        begins, ends = (k / q).tolist()
        return next((law for law in _LAWS if abs(begins - law) < CLOSE * max(1, abs(law))), begins), ends

    def foundation_modulus(self, period: float) -> float:
        """The first row's K where the table begins flat; 0 where K goes like q there, `inf` where like 1/q^2."""
        flat = self.stiffnesses[0] * period / self.contact_modulus
        return flat if self._powers[0] == 0 else 0.0 if self._powers[0] == 1 else math.inf

    def to_dict(self) -> dict[str, Any]:
        return {
            "layer": self.name,
            "thickness": self.thickness,
            "contact_modulus": self.contact_modulus,
            "stiffness_rows": len(self.wave_numbers),
            "stiffness_source": self.source,
        }

    def in_units(self, length: float, pressure: float = 1.0) -> Self:
        return replace(
            self,
            wave_numbers=tuple(q / length for q in self.wave_numbers),
            stiffnesses=tuple(k * pressure / length for k in self.stiffnesses),
            contact_modulus=self.contact_modulus * pressure,
        )


def _column(name: str, values: Any) -> Array64:
    allowed = f"{_FEWEST} or more finite real numbers > 0"
    column = checks.array(name, values, allowed, _FEWEST)
    bad = np.flatnonzero(~((column > 0) & np.isfinite(column)))
    if bad.size:
        raise ValueError(f"{name} are {column[bad[0]]:.6g} in row {bad[0] + 1}; allowed: {allowed}")
    return column


def _left_out(q: Array64, k: Array64) -> tuple[float, float]:
    """The largest relative change of K where every other row is left out, and the q where that is."""
    every = np.arange(0, q.size, 2)
    left_out = np.arange(1, every[-1], 2)
    log_q, log_k = np.log(q), np.log(k)
    error = np.abs(np.expm1(_cubic(log_q[every], log_k[every], log_q[left_out]) - log_k[left_out]))
    worst = int(np.argmax(error))
    return float(error[worst]), float(q[left_out[worst]])


def _missing(which: str, q: float, end: float, law: str) -> str:
    place, other = ("begins", "period") if which == "long" else ("ends", "num_points")
    lack = f"the {which} waves of this scene, q = {q:.4g}: the table {place} at {end:.4g}, and not as a {law}"
    return f"stiffnesses lack {lack}; allowed: a longer table, or another {other}"


def _cubic(x: Array64, y: Array64, at: Array64) -> Array64:
    """The monotone piecewise cubic through the points (x, y) at places inside of them."""
    step = np.diff(x)
    secant = np.diff(y) / step
    before, after = secant[:-1], secant[1:]
    weights = 2 * step[1:] + step[:-1], step[1:] + 2 * step[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = (weights[0] + weights[1]) / (weights[0] / before + weights[1] / after)
    slope = np.concatenate([secant[:1], np.where(before * after > 0, mean, 0.0), secant[-1:]])
    place = np.clip(np.searchsorted(x, at, side="right") - 1, 0, step.size - 1)
    t, left, right, over = at - x[place], slope[place], slope[place + 1], secant[place]
    bend = (left + right - 2 * over) / step[place]
    return np.asarray(y[place] + t * (left + t * ((over - left) / step[place] - bend + t * bend / step[place])))
