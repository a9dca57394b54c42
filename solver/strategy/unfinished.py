"""What an iteration that was ended at a residual leaves of the contact area's error."""

import math


def iteration_share(free_residual: float, area: float = 0.0, rounded: bool = False) -> float:
    """Estimated relative error of a_r that a free residual leaves; `inf` where the area may be anything.

    Measured: up to 0.12 of residuals below 1e-3, 0.3 below blunt indenters on thin layers; 0.8 of one of 0.03, and of
    no meaning beyond. rounded: whether the residual may be rounding to float32, which acts at the edges; measured up to
    1.2 of it. area: a_r. If that is nearly the whole period, a load that is off by the residual moves the ends of the
    last gaps, as under H. M. Westergaard's wave: p = p_full [1 - cos^2(pi a_r/2)].
    """
    open_part = math.cos(math.pi / 2 * area)
    of_gaps = 2 / math.pi * (math.hypot(open_part, math.sqrt(free_residual)) - open_part) if area < 1 else 0.0
    share = max((1.5 if rounded else 0.4) * free_residual, of_gaps) + 30 * free_residual**2
    return share if share < 1 else math.inf


def near_full_contact(area: float) -> float:
    """How many times more of a small residual is left in an area that is nearly the whole period, see
    `iteration_share`; at least 1.
    """
    return max(1.0, math.tan(math.pi / 2 * area) / (0.4 * math.pi)) if area < 1 else 1.0
