"""Constants that kernels and their callers share: the chunk, the padding and the slots of FIRE's control state.

The control state is one float64 array. Scalars live there, not in kernel arguments, because a recorded graph freezes
its scalar arguments. All slots are dimensionless in the units of the discrete problem (period, contact modulus and mean
pressure are 1).
"""

CHUNK = 1024
"""Points per kernel thread: a power of two above Warp's unroll limit (16), else LLVM leaves the loop scalar."""

COLUMNS, STRIDE = 64, 68
"""Real columns that a four-step transform works on at a time, and the values from one of their rows to the next: if
that were a power of two, the rows would push each other out of the cache (6 times as long)."""

FORCE, HOLDING, POWER, VELOCITY = range(4)
PARTS = VELOCITY + 1
"""FIRE's sums of every chunk, one part after the other in one array: f.f, the number of held nodes, v.f and v.v."""

FOLDED = 32
"""Sums that a GPU leaves of each part for FIRE's control step."""

TOUCHING = 2.0**-60
"""Velocity that marks a node on the wall. As good as 0 (its square is the smallest that float32 holds well), positive,
so that the next step finds the node on the wall again, and read instead of u and h by the passes that need the
contact."""

# First the caller's slots (names of Bitzek et al., Phys. Rev. Lett. 97, 170201 (2006), table I). STIFFEST: largest
# eigenvalue of the (mass-weighted) stiffness on free nodes; TOLERANCE: on the rms free force over the mean pressure;
# NUM_POINTS: with padding, whose nodes are held. Then those of `fire_control`. HELD: nodes that the wall carries,
# padding included; STOPPED: 1 once converged or diverged, and a converged u is not changed by the steps that follow.
# fmt: off
(
    DT_MAX, N_MIN, F_INC, F_DEC, ALPHA_START, F_ALPHA, STIFFEST, TOLERANCE, NUM_POINTS,
    DT, ALPHA, N_POSITIVE, MIX, GAIN, ITERATION, RESIDUAL, HELD, STOPPED,
) = range(18)
# fmt: on
STATE_LENGTH = STOPPED + 1

SAMPLES = 8
"""Of a slope over a narrow patch, or of the pressure over a gap, at t = cos[pi (k + 1/2)/8], k = 0, 1, ... 7: their
mean is the one with the weight (1 - t^2)^-1/2."""
DEGREE, STENCIL = 6, 6
"""Of the polynomials around these, at most, and nodes through which heights are interpolated."""
OF_FIELD, OF_OWN, OF_HEIGHTS, CAUSED = range(4)
"""Places in `units`: factors from the field, from a run's own values and from heights to the equations' units, the last
one 0 unless heights are taken off (for gaps); then the part of the field that a unit of own values takes off 0, 1, ...
nodes away."""
FIRST, SIZE, MARGIN, MOMENT, EXPONENT = range(5)
"""Rows of `runs`: first node; nodes; nodes to each side that are looked at, too, 0 where nothing is around; M_1 a^(1 +
exponent), 0 for a gap, and its exponent."""
MIDDLE, HALF_WIDTH, SOLVED, DEEPER, CENTRE, FOURTH, SIXTH = range(7)
"""Rows of `ends`: m and a, to begin with and in the end [grid spacings]; 1 where they solve the equations, else 0. Of
patches: mean of the field around less the heights, with the weight of M_k; where the load acts. Fourth and sixth over
second differences of the heights, which are large where nodes do not tell the heights between them."""
CLOSE = 4e-4
"""Least half-width to begin with [grid spacings], and length of a step of Newton's method that needs no other, over the
half-width or the spacing, the smaller one."""

NODES, GAPS, _, KNOWN, PRESSED = range(5)
"""First rows of what `pressed_ends` reads of patches: their nodes; those of the gaps to their left and right; 1 where
the half-space's edge may be known, else 0; the pressures of the last three nodes of left and of right ends, last node
first."""
OFFSET, SPREAD, BEFORE, ALONE = range(0, 8, 2)
"""First rows of its results, for left and right ends: how far the edge lies inside the last node [grid spacings]; how
little the pressures look like an edge; the offset of the turn before; pressures without other ends' effect."""
SHIFT, DELTA, GROWTH, ROWS = range(4)
FAR_FIELDS, TABLE = ROWS + 9, ROWS + 18
"""First places of an edge curve's numbers, see `EdgeCurve.packed`; GROWTH: the power beyond the table."""
TURNS = 3
"""Until ends agree with pressures, or with the modulus that a layer has for their width."""
ALIKE = 0.15
"""Grid spacings by which two estimates of an edge may differ to be of an edge at all."""

STEP = 0
"""The active set's only scalar, in an array of its own: length of a step along a direction."""


def padded_length(length: int, multiple: int = CHUNK) -> int:
    """Smallest multiple of `CHUNK`, or of another number, that holds `length` values."""
    return -(-length // multiple) * multiple
