"""The Warp kernel that finds where narrow patches and gaps end, a thread for each; derived in `solver/grid/narrow.py`.

Float64, in grid spacings. Beside sums over some hundred values the rest of a thread is nothing, so that it takes one
run after the other on a CPU.
"""

import warp as wp

from . import layout

wp.set_module_options({"enable_backward": False})

Doubles = wp.array[wp.float64]
f64 = wp.float64
MIDDLE, HALF_WIDTH, SOLVED = (wp.constant(one) for one in (layout.MIDDLE, layout.HALF_WIDTH, layout.SOLVED))
CENTRE, HALF = wp.constant(layout.CENTRE), wp.constant(layout.HALF)
MOMENT, EXPONENT, SIGN = (wp.constant(one) for one in (layout.MOMENT, layout.EXPONENT, layout.SIGN))
SAMPLES = wp.constant(layout.SAMPLES)
DEGREE = wp.constant(layout.DEGREE)
STENCIL = wp.constant(layout.STENCIL)
STEPS = wp.constant(layout.NEWTON_STEPS)
STEP, NEARLY, CLOSE = (wp.constant(f64(one)) for one in (layout.NEWTON_STEP, layout.NEARLY, layout.CLOSE))
ANGLE = wp.constant(f64(layout.ANGLE))


@wp.kernel
def narrow_ends(profile: Doubles, powers: Doubles, runs: Doubles, ends: Doubles):
    """M_0 = 0 and M_1 = moment/a^(1 + exponent) by Newton's method; M_k are the means of g t^k over a run from m - a to
    m + a, g the slope of the heights less that of the polynomial around it.

    profile: heights, (N,); powers: from six of them to coefficients; runs, ends: rows of `layout`, one after the other.
    """
    run = wp.tid()
    count, n = ends.shape[0] // (SOLVED + 1), profile.shape[0]
    centre, half = runs[CENTRE * count + run], runs[HALF * count + run]
    m = f64(ends[MIDDLE * count + run])
    a = wp.max(ends[HALF_WIDTH * count + run], CLOSE)
    good = bool(False)
    going_on = bool(True)
    for turn in range(STEPS):
        if going_on:
            m_0 = f64(0.0)
            m_1 = f64(0.0)
            by_m = f64(0.0)
            by_both = f64(0.0)
            by_a = f64(0.0)
            for sample in range(SAMPLES):
                t = wp.cos(ANGLE * (f64(sample) + f64(0.5)))
                x = m + a * t
                s = (x - centre) / half
                value = f64(0.0)
                first = f64(0.0)
                second = f64(0.0)
                for k in range(DEGREE + 1):
                    second = second * s + first
                    first = first * s + value
                    value = value * s + runs[k * count + run]
                g = -first / half
                slope = -f64(2.0) * second / (half * half)
                node = int(wp.floor(x))
                s = x - wp.floor(x)
                value = f64(0.0)
                first = f64(0.0)
                second = f64(0.0)
                for k in range(STENCIL):
                    c = f64(0.0)
                    for j in range(STENCIL):
                        c += profile[((node + j - 2) % n + n) % n] * powers[j * STENCIL + k]
                    second = second * s + first
                    first = first * s + value
                    value = value * s + c
                g += first
                slope += f64(2.0) * second
                m_0 += g
                m_1 += g * t
                by_m += slope
                by_both += slope * t
                by_a += slope * t * t
            power = f64(1.0) + runs[EXPONENT * count + run]
            wanted = f64(SAMPLES) * runs[MOMENT * count + run] * wp.pow(a, -power)
            f = m_1 - wanted
            by_a += power * wanted / a
            determinant = by_m * by_a - by_both * by_both
            if runs[SIGN * count + run] * determinant > f64(0.0):
                by_middle = (m_0 * by_a - f * by_both) / determinant
                by_width = (f * by_m - m_0 * by_both) / determinant
                length = wp.max(wp.abs(by_middle), wp.abs(by_width))
                most = wp.min(STEP, a / f64(2.0))
                part = f64(1.0)
                if turn >= STEPS // 2 and length > NEARLY:
                    part = f64(0.5)
                good = length < wp.min(NEARLY, STEP * a)
                going_on = length >= CLOSE * wp.min(a, f64(1.0))
                m -= part * wp.clamp(by_middle, -most, most)
                a -= part * wp.clamp(by_width, -most, most)
            else:
                good = False
                going_on = False
    ends[MIDDLE * count + run] = m
    ends[HALF_WIDTH * count + run] = a
    ends[SOLVED * count + run] = wp.where(good, f64(1.0), f64(0.0))
