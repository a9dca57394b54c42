"""The Warp kernel that finds where narrow patches and gaps end, a thread for each; derived in `solver/grid/narrow.py`.

Float64, in grid spacings.
"""

import warp as wp

from . import layout

wp.set_module_options({"enable_backward": False})

Doubles = wp.array[wp.float64]
f64 = wp.float64
SAMPLES = wp.constant(layout.SAMPLES)
DEGREE, STENCIL = wp.constant(layout.DEGREE), wp.constant(layout.STENCIL)
MIDDLE, HALF_WIDTH, SOLVED = (wp.constant(one) for one in (layout.MIDDLE, layout.HALF_WIDTH, layout.SOLVED))
CENTRE, HALF = wp.constant(layout.CENTRE), wp.constant(layout.HALF)
MOMENT, EXPONENT = wp.constant(layout.MOMENT), wp.constant(layout.EXPONENT)
CLOSE = wp.constant(f64(layout.CLOSE))
STEPS = wp.constant(24)
"""Of Newton's method, at most. In their second half those longer than `NEARLY` are halved, as they may go to and fro
about a node, where the polynomials of the heights change."""
STEP, NEARLY = wp.constant(f64(0.25)), wp.constant(f64(0.02))
"""Length of any step and of the last one, at most [grid spacings]; the last one is at most `STEP` of the half-width,
too."""


@wp.func
def heights(profile: Doubles, powers: Doubles, x: f64):
    """h' and h'' at x, by the polynomial through the six nodes around it."""
    n, node = profile.shape[0], int(wp.floor(x))
    t = x - wp.floor(x)
    value, first, second = f64(0.0), f64(0.0), f64(0.0)
    for k in range(STENCIL):
        coefficient = f64(0.0)
        for j in range(STENCIL):
            coefficient += profile[((node + j - 2) % n + n) % n] * powers[j * STENCIL + k]
        second = second * t + first
        first = first * t + value
        value = value * t + coefficient
    return first, f64(2.0) * second


@wp.func
def around(runs: Doubles, count: int, run: int, x: f64):
    """The first and second derivatives at x of the polynomial around a run."""
    half = runs[HALF * count + run]
    t = (x - runs[CENTRE * count + run]) / half
    value, first, second = f64(0.0), f64(0.0), f64(0.0)
    for k in range(DEGREE + 1):
        second = second * t + first
        first = first * t + value
        value = value * t + runs[k * count + run]
    return first / half, f64(2.0) * second / (half * half)


@wp.kernel
def narrow_ends(profile: Doubles, powers: Doubles, runs: Doubles, ends: Doubles):
    """M_0 = 0 and M_1 = moment/a^(1 + exponent) by Newton's method for m and a; M_k are the means of g t^k over a run
    from m - a to m + a, t = (x - m)/a, and g is the slope of the heights less that of the polynomial around the run.

    profile: heights, (N,); powers: from six of them to coefficients; runs, ends: rows of `layout`, one after the other.
    """
    run, count = wp.tid(), ends.shape[0] // (SOLVED + 1)
    m = f64(ends[MIDDLE * count + run])
    a = wp.max(ends[HALF_WIDTH * count + run], CLOSE)
    moment, power = runs[MOMENT * count + run], f64(1.0) + runs[EXPONENT * count + run]
    good, going_on = bool(False), bool(True)
    for turn in range(STEPS):
        if going_on:
            m_0, m_1 = f64(0.0), f64(0.0)
            by_m, by_both, by_a = f64(0.0), f64(0.0), f64(0.0)
            for sample in range(SAMPLES):
                t = wp.cos(f64(wp.pi) * (f64(sample) + f64(0.5)) / f64(SAMPLES))
                g, slope = heights(profile, powers, m + a * t)
                g_around, slope_around = around(runs, count, run, m + a * t)
                g -= g_around
                slope -= slope_around
                m_0 += g
                m_1 += g * t
                by_m += slope
                by_both += slope * t
                by_a += slope * t * t
            wanted = f64(SAMPLES) * moment * wp.pow(a, -power)
            f = m_1 - wanted
            by_a += power * wanted / a
            determinant = by_m * by_a - by_both * by_both
            good, going_on = False, False
            if (moment > f64(0.0)) == (determinant > f64(0.0)) and determinant != f64(0.0):
                by_middle = (m_0 * by_a - f * by_both) / determinant
                by_width = (f * by_m - m_0 * by_both) / determinant
                length = wp.max(wp.abs(by_middle), wp.abs(by_width))
                good = length < wp.min(NEARLY, STEP * a)
                going_on = length >= CLOSE * wp.min(a, f64(1.0))
                most, part = wp.min(STEP, a / f64(2.0)), f64(1.0)
                if turn >= STEPS // 2 and length > NEARLY:
                    part = f64(0.5)
                m -= part * wp.clamp(by_middle, -most, most)
                a -= part * wp.clamp(by_width, -most, most)
    ends[MIDDLE * count + run] = m
    ends[HALF_WIDTH * count + run] = a
    ends[SOLVED * count + run] = wp.where(good, f64(1.0), f64(0.0))
