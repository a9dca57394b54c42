"""The Warp kernels that find where patches and gaps end: by the last pressures of all patches, in one thread; by the
loads of narrow ones, and for gaps, in a thread for each; and the integrals of squared slopes between them. Derived in
`solver/grid/edges.py` and `narrow.py`.

Float64, in grid spacings.
"""

import math

import warp as wp

from . import layout

wp.set_module_options({"enable_backward": False})

Doubles = wp.array[wp.float64]
f64 = wp.float64
SAMPLES, ALL = wp.constant(layout.SAMPLES), wp.constant(f64(layout.SAMPLES))
ANGLE = wp.constant(f64(math.pi / layout.SAMPLES))
DEGREE, STENCIL = wp.constant(layout.DEGREE), wp.constant(layout.STENCIL)
COEFFICIENTS = wp.constant(layout.DEGREE + 1)  # a loop over so many is unrolled
Polynomial = wp.types.vector(length=layout.DEGREE + 1, dtype=f64)
OF_FIELD, OF_OWN, OF_HEIGHTS, CAUSED = (wp.constant(one) for one in range(layout.CAUSED + 1))
FIRST, SIZE, MARGIN, MOMENT, EXPONENT = (wp.constant(one) for one in range(layout.EXPONENT + 1))
MIDDLE, HALF_WIDTH, SOLVED, DEEPER, CENTRE, FOURTH, SIXTH = (wp.constant(one) for one in range(layout.SIXTH + 1))
CLOSE = wp.constant(f64(layout.CLOSE))
STEPS = wp.constant(24)
"""Of Newton's method, at most. In their second half those longer than `NEARLY` are halved, as they may go to and fro
about a node, where the polynomials of the heights change."""
STEP, NEARLY = wp.constant(f64(0.25)), wp.constant(f64(0.02))
"""Length of any step and of the last one, at most [grid spacings]; the last one is at most `STEP` of the half-width,
too."""


@wp.func
def heights(profile: Doubles, powers: Doubles, x: f64):
    """h, h' and h'' at x, by the polynomial through the six nodes around it."""
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
    return value, first, f64(2.0) * second


@wp.func
def recurrence(k: int, nodes: int):
    """b_k in P_(k+1) = x P_k - b_k P_(k-1), polynomials that are orthogonal on so many nodes, a spacing apart, about
    x = 0; also the sum of P_k^2 over that of P_(k-1)^2 (W. Gautschi, Orthogonal Polynomials (2004), table 1.2).
    """
    square, all = f64(k * k), f64(nodes * nodes)
    return square * (all - square) / (f64(16.0) * square - f64(4.0))


@wp.func
def around(fitted: Polynomial, nodes: int, x: f64):
    """A fitted polynomial at x from the middle of its nodes, with both derivatives."""
    value, first, second = f64(0.0), f64(0.0), f64(0.0)
    p, p_first, p_second = f64(1.0), f64(0.0), f64(0.0)
    before, before_first, before_second = f64(0.0), f64(0.0), f64(0.0)
    for k in range(COEFFICIENTS):
        value += fitted[k] * p
        first += fitted[k] * p_first
        second += fitted[k] * p_second
        b = recurrence(k, nodes)
        after, after_first = x * p - b * before, p + x * p_first - b * before_first
        after_second = f64(2.0) * p_first + x * p_second - b * before_second
        before, before_first, before_second = p, p_first, p_second
        p, p_first, p_second = after, after_first, after_second
    return value, first, second


@wp.func
def fit(field: Doubles, own: Doubles, profile: Doubles, units: Doubles, first: int, size: int, margin: int):
    """The polynomial of least squares, on a run and `margin` nodes to each side, through a field plus the part that
    the run's own values, less the heights for a gap, have taken off it.
    """
    n, nodes, fitted = field.shape[0], size + 2 * margin, Polynomial()
    degree = wp.clamp(nodes - 2, 2, DEGREE)
    for j in range(nodes):
        value = units[OF_FIELD] * field[((first - margin + j) % n + n) % n]
        for i in range(size):
            node = (first + i) % n
            caused = units[CAUSED + wp.abs(j - margin - i)]
            value += caused * (units[OF_OWN] * own[node] - units[OF_HEIGHTS] * profile[node])
        x = f64(j) - f64(nodes - 1) / f64(2.0)
        p, before, squares = f64(1.0), f64(0.0), f64(nodes)
        for k in range(COEFFICIENTS):
            if k <= degree:
                fitted[k] += value * p / squares
            after = x * p - recurrence(k, nodes) * before
            before = p
            p = after
            squares *= recurrence(k + 1, nodes)
    return fitted


@wp.func
def jaggedness(profile: Doubles, first: int, size: int):
    """Fourth and sixth over second differences of the heights, sums of their magnitudes at the ends and in the middle
    of a run; infinite where nothing bends.
    """
    n = profile.shape[0]
    second, fourth, sixth = f64(0.0), f64(0.0), f64(0.0)
    for place in range(4):
        node = first + n
        if place == 1:
            node += (size - 1) // 2
        if place == 2:
            node += size // 2
        if place == 3:
            node += size - 1
        h = profile[node % n]
        one = profile[(node + 1) % n] + profile[(node - 1) % n]
        two = profile[(node + 2) % n] + profile[(node - 2) % n]
        three = profile[(node + 3) % n] + profile[(node - 3) % n]
        second += wp.abs(one - f64(2.0) * h)
        fourth += wp.abs(two - f64(4.0) * one + f64(6.0) * h)
        sixth += wp.abs(three - f64(6.0) * two + f64(15.0) * one - f64(20.0) * h)
    some = second > f64(0.0)
    return wp.where(some, fourth / second, f64(wp.inf)), wp.where(some, sixth / second, f64(wp.inf))


@wp.func
def moments(profile: Doubles, powers: Doubles, fitted: Polynomial, nodes: int, middle: f64, gaps: bool, m: f64, a: f64):
    """Sums over the samples of g and g t, see `narrow_ends`, and of g', g' t and g' t^2."""
    m_0, m_1 = f64(0.0), f64(0.0)
    by_m, by_both, by_a = f64(0.0), f64(0.0), f64(0.0)
    for sample in range(SAMPLES):
        t = wp.cos(ANGLE * (f64(sample) + f64(0.5)))
        g, slope, bend = around(fitted, nodes, m + a * t - middle)
        if not gaps:
            _h, of_heights, bend_of_heights = heights(profile, powers, m + a * t)
            g, slope = of_heights - slope, bend_of_heights - bend
        m_0 += g
        m_1 += g * t
        by_m += slope
        by_both += slope * t
        by_a += slope * t * t
    return m_0, m_1, by_m, by_both, by_a


@wp.func
def of_load(profile: Doubles, powers: Doubles, fitted: Polynomial, nodes: int, middle: f64, m: f64, a: f64):
    """Of a patch, the mean of the field around it less the heights, and the place where the load acts."""
    deeper, m_1, m_2 = f64(0.0), f64(0.0), f64(0.0)
    for sample in range(SAMPLES):
        t = wp.cos(ANGLE * (f64(sample) + f64(0.5)))
        surface, slope, _bend = around(fitted, nodes, m + a * t - middle)
        h, of_heights, _bend_of_heights = heights(profile, powers, m + a * t)
        deeper += (surface - h) / ALL
        m_1 += (of_heights - slope) * t
        m_2 += (of_heights - slope) * t * t
    return deeper, m + a * m_2 / m_1


@wp.kernel
def narrow_ends(
    profile: Doubles,
    field: Doubles,
    own: Doubles,
    units: Doubles,
    powers: Doubles,
    gaps: bool,
    runs: Doubles,
    ends: Doubles,
):
    """M_0 = 0 and M_1 = moment/a^(1 + exponent) by Newton's method for m and a; M_k are the means of g t^k over a run
    from m - a to m + a, t = (x - m)/a. For patches g is the slope of the heights less that of the field around the run,
    for gaps that field.

    profile, field, own: (N,); powers: from six heights to coefficients; units, runs, ends: see `layout`, rows one after
    the other.
    """
    run, count = wp.tid(), ends.shape[0] // (SIXTH + 1)
    first, size = int(runs[FIRST * count + run]), int(runs[SIZE * count + run])
    margin = int(runs[MARGIN * count + run])
    nodes, middle = size + 2 * margin, f64(first) + f64(size - 1) / f64(2.0)
    fitted = Polynomial()
    if margin > 0:
        fitted = fit(field, own, profile, units, first, size, margin)
    m = f64(ends[MIDDLE * count + run])
    a = wp.max(ends[HALF_WIDTH * count + run], CLOSE)
    moment, power = runs[MOMENT * count + run], f64(1.0) + runs[EXPONENT * count + run]
    good, going_on = bool(False), bool(True)
    for turn in range(STEPS):
        if going_on:
            m_0, m_1, by_m, by_both, by_a = moments(profile, powers, fitted, nodes, middle, gaps, m, a)
            wanted = ALL * moment * wp.pow(a, -power)
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
    fourth, sixth = jaggedness(profile, first, size)
    deeper, centre = of_load(profile, powers, fitted, nodes, middle, m, a)
    ends[MIDDLE * count + run] = m
    ends[HALF_WIDTH * count + run] = a
    ends[SOLVED * count + run] = wp.where(good, f64(1.0), f64(0.0))
    ends[DEEPER * count + run] = deeper
    ends[CENTRE * count + run] = centre
    ends[FOURTH * count + run] = fourth
    ends[SIXTH * count + run] = sixth


@wp.kernel
def squared_slopes(profile: Doubles, powers: Doubles, samples: Doubles, ends: Doubles):
    """Integrals of h'^2 between the ends of runs, by Gauss and Legendre.

    samples: places from -1 to 1, and their weights; ends: rows of left and right ends; the integrals come into the
    first.
    """
    run, count, places = wp.tid(), ends.shape[0] // 2, samples.shape[0] // 2
    left, right = f64(ends[run]), ends[count + run]
    half = (right - left) / f64(2.0)
    total = f64(0.0)
    for k in range(places):
        _h, slope, _bend = heights(profile, powers, left + half * (f64(1.0) + samples[k]))
        total += samples[places + k] * half * slope * slope
    ends[run] = total


NODES, GAPS, KNOWN, PRESSED = (wp.constant(one) for one in (layout.NODES, layout.GAPS, layout.KNOWN, layout.PRESSED))
OFFSET, SPREAD, BEFORE, ALONE = (
    wp.constant(one) for one in (layout.OFFSET, layout.SPREAD, layout.BEFORE, layout.ALONE)
)
SHIFT, DELTA, GROWTH = (wp.constant(one) for one in (layout.SHIFT, layout.DELTA, layout.GROWTH))
ROWS, FAR_FIELDS, TABLE = (wp.constant(one) for one in (layout.ROWS, layout.FAR_FIELDS, layout.TABLE))
TURNS, ALIKE = wp.constant(layout.TURNS), wp.constant(f64(layout.ALIKE))
NARROWEST = wp.constant(f64(0.5))
"""Gap between two patches that is believed [grid spacings]."""
NO_PRESSURE, LEAST_FACTOR = wp.constant(f64(2.0**-26)), wp.constant(f64(1e-3))
"""Of an edge at its last node, over that a spacing away; least edge function of a patch's other end."""


@wp.func
def edge_offset(curve: Doubles, last: f64, second: f64, third: f64):
    """theta from the last three pressures, and by how far it and that of the last two differ, before their bounds."""
    ratio = last / second
    two = curve[TABLE] - ratio * curve[TABLE + 1]
    two = two / (two + ratio * curve[TABLE]) - curve[SHIFT]
    if not wp.isfinite(two):
        two = f64(0.5) - curve[SHIFT]
    least, most = -curve[SHIFT], f64(1.0) - curve[SHIFT]
    bounded = wp.clamp(two, least, most)
    low = curve[ROWS] * last + curve[ROWS + 1] * second + curve[ROWS + 2] * third
    middle = curve[ROWS + 3] * last + curve[ROWS + 4] * second + curve[ROWS + 5] * third
    high = curve[ROWS + 6] * last + curve[ROWS + 7] * second + curve[ROWS + 8] * third
    theta = f64(-2.0) * low / middle
    for _ in range(TURNS):  # -theta middle/2 - 3/8 theta^2 high = low
        theta = f64(-2.0) * low / (middle + f64(0.75) * theta * high)
    theta += curve[DELTA]
    differ = f64(1.0)
    if wp.isfinite(theta):
        differ = wp.abs(theta - bounded)
    else:
        theta = bounded
    theta = wp.clamp(theta, least, most)
    if wp.abs(theta - bounded) >= ALIKE:  # the patch is too small for a third family
        theta = bounded
    return theta, wp.max(wp.abs(two - bounded), differ)


@wp.func
def in_row(curve: Doubles, theta: f64, width: f64, gap: f64, node: int):
    """The factor that a pressure has from all other ends, in a row of such patches and gaps on the half-space."""
    theta -= curve[DELTA]
    high, middle = curve[FAR_FIELDS + node], curve[FAR_FIELDS + 3 + node]
    low = curve[FAR_FIELDS + 6 + node]
    edge = middle - theta / f64(2.0) * low
    away = f64(0.0)  # from the edge, as the grid has it
    if edge > NO_PRESSURE:
        away = (high - f64(1.5) * theta * middle + f64(0.375) * theta * theta * low) / edge
    away = wp.min(away, width)
    wave = f64(wp.pi) / (width + gap)
    beyond = wp.sin(wave * wp.max(width - away, NARROWEST))
    if away != f64(0.0):
        beyond *= wp.sin(wave * away) / (wave * away)
    return wp.sin(wave * (gap / f64(2.0) + away)) * wp.sqrt(beyond)


@wp.func
def at_node(curve: Doubles, j: int):
    """S_j, see `EdgeCurve.at`."""
    last = curve.shape[0] - TABLE - 1
    value = f64(0.0)
    if j > last:
        value = curve[TABLE + last] * wp.pow((f64(j) + curve[SHIFT]) / (f64(last) + curve[SHIFT]), curve[GROWTH])
    elif j >= 0:
        value = curve[TABLE + j]
    return value


@wp.func
def beside(patches: Doubles, ends: Doubles, row: int, count: int, patch: int, side: int):
    """Width of a patch, not below two, and of the gap beside one of its ends. row: of the ends' offsets."""
    left, right = row * count, (row + 1) * count
    width = wp.max(patches[NODES * count + patch] - f64(1.0) - ends[left + patch] - ends[right + patch], f64(2.0))
    facing = ends[left + patch] + ends[right + (patch + count - 1) % count]
    if side == 1:
        facing = ends[right + patch] + ends[left + (patch + 1) % count]
    return width, wp.max(patches[(GAPS + side) * count + patch] + f64(1.0) + facing, NARROWEST)


@wp.kernel
def pressed_ends(curve: Doubles, patches: Doubles, rows: bool, ends: Doubles):
    """Offsets of all ends, by turns, in which each end takes the others for known.

    curve, patches, ends: see `layout`; rows: other ends act as those of a row of patches, whose given load then moves
    ends that are known and look like edges; else the patch's other end acts alone.
    """
    count = patches.shape[0] // (PRESSED + 6) + wp.tid()  # 0; without it the code is a twentieth to a sixth slower
    for end in range(2 * count):
        ends[OFFSET * count + end] = f64(0.5) - curve[SHIFT]
    for _turn in range(TURNS):
        for end in range(2 * count):
            ends[BEFORE * count + end] = ends[OFFSET * count + end]
        for end in range(2 * count):
            side, patch = end // count, end % count
            width, gap = beside(patches, ends, BEFORE, count, patch, side)
            beta = ends[(BEFORE + 1 - side) * count + patch] + curve[SHIFT]  # of the patch's other end
            for node in range(3):
                if rows:
                    factor = in_row(curve, ends[BEFORE * count + end], width, gap, node)
                else:
                    j = int(patches[NODES * count + patch]) - 1 - node
                    factor = (f64(1.0) - beta) * at_node(curve, j) + beta * at_node(curve, j - 1)
                    factor = wp.max(factor, LEAST_FACTOR)
                row = 3 * side + node
                ends[(ALONE + row) * count + patch] = patches[(PRESSED + row) * count + patch] / factor
            row = (ALONE + 3 * side) * count + patch
            theta, spread = edge_offset(curve, ends[row], ends[row + count], ends[row + 2 * count])
            ends[OFFSET * count + end] = theta
            ends[SPREAD * count + end] = spread
    if rows:
        second_order, known = f64(0.0), f64(0.0)
        for end in range(2 * count):
            ends[BEFORE * count + end] = ends[OFFSET * count + end]
            if ends[SPREAD * count + end] < ALIKE and patches[KNOWN * count + end % count] > f64(0.0):
                beta = ends[OFFSET * count + end] + curve[SHIFT]
                second_order += beta * beta - beta + f64(1.0 / 6.0)
                known += f64(1.0)
        for end in range(2 * count):
            if ends[SPREAD * count + end] < ALIKE and patches[KNOWN * count + end % count] > f64(0.0):
                width, gap = beside(patches, ends, BEFORE, count, end % count, end // count)
                tangent = wp.tan(f64(wp.pi / 2.0) * width / (width + gap))
                mean = second_order / (f64(8.0) * known)
                ends[OFFSET * count + end] += (
                    f64(wp.pi) / (width + gap) * (f64(3.0) / tangent + tangent) / f64(2.0) * mean
                )
