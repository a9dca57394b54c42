"""Where narrow gaps end, also gaps of a few nodes.

If one gap were pressed shut, the pressure there would be partly negative; call it p (`surroundings`). The gap opens so
far that no pressure is left in it, and closes smoothly: at its ends the pressure is 0 and not infinite. So over the gap
from m - b to m + b

    int p(m + b t) (1 - t^2)^-1/2 dt = 0 and int p(m + b t) t (1 - t^2)^-1/2 dt = 0, over -1 < t < 1

(both stress intensity factors of a crack with the stress -p on its faces are 0; H. Tada, P. C. Paris and G. R. Irwin,
The Stress Analysis of Cracks Handbook (1973)). These two equations give m and b, by Newton's method.
"""

from dataclasses import dataclass

import numpy as np

from ..arrays import Array64, Mask
from .surroundings import Surroundings

_SAMPLES = 8  # of the pressure over a gap
_T1 = np.cos(np.pi * (np.arange(_SAMPLES) + 0.5) / _SAMPLES)
_MOMENTS = np.stack([np.ones(_SAMPLES), _T1, _T1 * _T1], axis=1) / _SAMPLES
_STEPS, _STEP, _CLOSE = 12, 0.25, 1e-6  # of Newton's method: most, their length and the last one's [grid spacings]


@dataclass(frozen=True, eq=False)
class GapEnds:
    """Where some gaps end."""

    left: Array64
    """Left ends, shape (gaps,) [grid spacings]."""
    right: Array64
    """Right ends, shape (gaps,) [grid spacings]."""
    solved: Mask
    """For which the equations were solved, shape (gaps,)."""


def gap_ends(closed: Surroundings, left: Array64, right: Array64) -> GapEnds:
    """Ends of some gaps. closed: p, see the module; left, right: where to begin, shape (gaps,) [grid spacings]."""
    m, b = (left + right) / 2, (right - left) / 2
    solved = np.zeros(m.size, dtype=bool)
    going_on = np.arange(m.size)
    for _ in range(_STEPS):
        now, half = going_on, b[going_on]
        at = m[now, None] + half[:, None] * _T1
        f, f_1 = (closed.values(now, at) @ _MOMENTS[:, :2]).T
        slope, second = closed.slope(now, at)
        of_one, of_t1, of_t1_t1 = (slope @ _MOMENTS).T  # derivatives of both: with respect to m, and to b
        determinant = of_one * of_t1_t1 - of_t1 * of_t1
        usable = determinant < 0
        step = np.stack([f * of_t1_t1 - f_1 * of_t1, f_1 * of_one - f * of_t1])
        step = np.where(usable, step / np.where(usable, determinant, 1.0), 0.0)
        wanted, most = np.abs(step).max(axis=0), np.minimum(_STEP, half / 2)
        step = np.clip(step, -most, most)
        m[now], b[now] = m[now] - step[0], half - step[1]
        solved[now] = usable & (wanted < _CLOSE) & (second.mean(axis=1) > 0)
        going_on = now[usable & (wanted >= _CLOSE)]
        if not going_on.size:
            break
    return GapEnds(m - b, m + b, solved)
