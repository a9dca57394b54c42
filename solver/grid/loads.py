"""Where narrow patches end, from their loads: also patches of a few nodes.

Over a patch from m - a to m + a let g = h' - w' be the indenter's slope less that of the surface around it
(`surroundings`), and b_k = 2/pi int g(m + a t) T_k(t) (1 - t^2)^-1/2 dt over -1 < t < 1. The patch then has

    the load P = pi/4 E* a b_1, and b_0 = 0

(inversion of the finite Hilbert transform, K. L. Johnson, Contact Mechanics (1985), section 2.7, with pressures that
are 0 at both ends: for that b_0 has to be 0). These two equations give m and a, by Newton's method. The load is a sum
over the nodes.

How well a grid knows that load is told by the level. A patch with the load P is pressed into the surface around it by

    w - h = 2 P/(pi E*) ln(2/a), its mean with the weight (1 - t^2)^-1/2,

lengths in grid spacings as `few_nodes.response` has it far from a node; by how much w - h differs from that
`shares` puts right.

On a layer that the grid does not resolve a patch of one or two nodes can be estimated only: as if nothing were around
it and the layer were a half-space of the modulus 2K(q)/q at q = 3 pi/(4 a), which makes a parabola's load right on the
half-space and on a Winkler foundation.
"""

from dataclasses import dataclass, fields

import numpy as np

from ..arrays import Array64, Mask
from .heights import Heights
from .layer_on_grid import Modulus
from .surroundings import Surroundings

_SAMPLES = 8  # of the slope over a patch
_ANGLES = np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES
_T1, _T2 = np.cos(_ANGLES), np.cos(2 * _ANGLES)
_MOMENTS = 2 / _SAMPLES * np.stack([np.ones(_SAMPLES), _T1, _T2], axis=1)
_BENT_MOMENTS = 2 / _SAMPLES * np.stack([np.ones(_SAMPLES), _T1, _T1 * _T1], axis=1)
_WAVE = 3 * np.pi / 4  # q a at which the layer's modulus is taken
_STEPS, _STEP, _CLOSE = 12, 0.25, 1e-3  # of Newton's method: most, their length and the last one's [grid spacings]
_HALVED_FROM, _NEARLY = 6, 0.02
"""Steps after which they are halved, as they may go to and fro about a node, where the polynomials of the heights
change; and what the last one may be then [grid spacings]."""
_GUESSED = 0.75  # distance of the first guess of a middle from halfway between the end nodes, at most [grid spacings]


@dataclass(frozen=True, eq=False)
class FromLoads:
    """Where some patches end, by their loads."""

    centre: Array64
    """m, shape (patches,) [grid spacings]."""
    half_width: Array64
    """a, shape (patches,) [grid spacings]."""
    centre_of_load: Array64
    """m + a b_2/(2 b_1), shape (patches,) [grid spacings]."""
    solved: Mask
    """For which the equations were solved, shape (patches,)."""

    def part(self, which: Mask) -> "FromLoads":
        """Those of some of the patches, shape (patches,)."""
        return FromLoads(*(getattr(self, each.name)[which] for each in fields(self)))


def from_loads(
    around: Surroundings,
    heights: Heights,
    load: Array64,
    centre: Array64,
    half_width: Array64,
    modulus: Modulus | None = None,
) -> FromLoads:
    """Ends of some patches. load: over E* [grid spacings]; centre, half_width: where to begin [grid spacings]; all of
    shape (patches,). modulus: of a layer that the grid does not resolve.
    """
    m, a, going_on = centre.copy(), half_width.copy(), np.arange(load.size)
    moments, solved = np.ones((load.size, 3)), np.zeros(load.size, dtype=bool)
    for turn in range(_STEPS):
        at = m[going_on, None] + a[going_on, None] * _T1
        g, bent = heights.slope(at)
        if modulus is None:
            by_others = around.slope(going_on, at)
            g, bent = g - by_others[0], bent - by_others[1]
        moments[going_on] = b = g @ _MOMENTS
        stiffness = _stiffness(modulus, a[going_on]) if modulus else (1.0, 0.0)
        step, usable = _newton(load[going_on], a[going_on], b, bent @ _BENT_MOMENTS, *stiffness)
        wanted, most = np.abs(step).max(axis=0), np.minimum(_STEP, 0.5 * a[going_on])
        step = np.minimum(np.maximum(step, -most), most) * (0.5 if turn >= _HALVED_FROM else 1.0)
        a[going_on], m[going_on] = a[going_on] - step[0], m[going_on] - step[1]
        close = wanted < (_CLOSE if turn < _STEPS - 1 else _NEARLY)
        solved[going_on] = usable & close & (b[:, 1] > 0) & (load[going_on] > 0)
        going_on = going_on[usable & (wanted >= _CLOSE)]
        if not going_on.size:
            break
    with np.errstate(divide="ignore", invalid="ignore"):
        skew = moments[:, 2] / moments[:, 1]
    return FromLoads(m, a, m + a * skew / 2, solved)


def first_centre(around: Surroundings, heights: Heights, resolved: bool) -> Array64:
    """Where the gap is narrowest, estimated from halfway between the end nodes of each patch, shape (patches,) [grid
    spacings]. resolved: whether what is around the patches counts.
    """
    slope, bent = heights.slope_in_the_middle(around.middle)
    if resolved:
        slope = slope - around.slope(np.arange(slope.size), around.middle[:, None])[0][:, 0]
    return np.asarray(around.middle - np.clip(slope / np.maximum(bent, 1e-300), -_GUESSED, _GUESSED))


def level_error(found: FromLoads, around: Surroundings, heights: Heights, load: Array64) -> Array64:
    """By how much the patches would have to lie deeper for their loads, shape (patches,) [grid spacings].

    load: as in `from_loads`.
    """
    at = found.centre[:, None] + found.half_width[:, None] * _T1
    pressed = (around.values(np.arange(load.size), at) - heights.values(at)).mean(axis=1)
    return np.asarray(pressed - punch_compliance(found.half_width) * load)


def punch_compliance(half_width: Array64) -> Array64:
    """Displacement of a flat punch by a unit load, as deep as `few_nodes.response` has it, of their shape (E* = 1).

    half_width: [grid spacings].
    """
    return np.asarray(2 / np.pi * np.log(2 / half_width))


def _newton(
    load: Array64, a: Array64, b: Array64, bent: Array64, stiff: Array64 | float, rise: Array64 | float
) -> tuple[Array64, Mask]:
    """The step in a and m, shape (2, patches), of Newton's method for the load and b_0 = 0; and where there is one.

    b, bent: moments of the slope and of its derivative; stiff, rise: modulus over E* and its logarithmic derivative
    with respect to a.
    """
    (b0, b1, _), (of_one, of_t1, of_t1_t1) = b.T, bent.T
    f = np.pi / 4 * stiff * a * b1 - load
    f_a = np.pi / 4 * stiff * ((1 + rise) * b1 + a * of_t1_t1)
    f_m = np.pi / 4 * stiff * a * of_t1
    determinant = f_a * of_one - f_m * of_t1
    usable = determinant > 0
    step = np.stack([f * of_one - b0 * f_m, b0 * f_a - f * of_t1]) / np.where(usable, determinant, 1.0)
    return np.where(usable, step, 0.0), usable


def _stiffness(modulus: Modulus, a: Array64) -> tuple[Array64, Array64]:
    """The layer's modulus over E* for patches of the half-width a, and its logarithmic derivative with respect to a."""
    step = 1e-3
    here, wider = modulus(np.stack([_WAVE / a, _WAVE / (a * (1 + step))]))
    return here, (wider / here - 1) / step
