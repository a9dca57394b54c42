"""What kernels and their callers agree on: the chunk, the padding and the slots of FIRE's control state.

The control state is one float64 array. Scalars live there, not in kernel arguments, because a recorded graph freezes
its scalar arguments. All slots are dimensionless in the units of the discrete problem (period, contact modulus and mean
pressure are 1).
"""

CHUNK = 1024
"""Points per kernel thread: a power of two above Warp's unroll limit (16), else LLVM leaves the loop scalar."""

COLUMNS, STRIDE = 64, 68
"""Real columns that a four-step transform works on at a time, and the values from one of their rows to the next: if
that were a power of two, the rows would push each other out of the cache (6 times as long)."""

FOLDED = 32
"""Sums that a GPU leaves of each array of sums for FIRE's control step."""

TOUCHING = 2.0**-60
"""Velocity that marks a node on the wall. As good as 0 (its square is the smallest that float32 holds well), positive,
so that the next step finds the node on the wall again, and read instead of u and h by the passes that need the
contact."""

# Parameters, written by the caller (names of Bitzek et al., Phys. Rev. Lett. 97, 170201 (2006), table I).
DT_MAX = 0
N_MIN = 1
F_INC = 2
F_DEC = 3
ALPHA_START = 4
F_ALPHA = 5
STIFFEST = 6  # largest eigenvalue of the (mass-weighted) stiffness on the free nodes
TOLERANCE = 7  # on the rms free force over the mean pressure
NUM_POINTS = 8  # with padding, whose nodes are held

# Dynamic state, written by `fire_control`.
DT = 9
ALPHA = 10
N_POSITIVE = 11
MIX = 12
GAIN = 13
ITERATION = 14
RESIDUAL = 15
HELD = 16  # nodes the wall carries, padding included
STOPPED = 17  # 1 once converged or diverged: a converged u is not changed by the steps that follow

STATE_LENGTH = 18


# The active set's scalars, in an array of their own.
STEP = 0  # length of a step along a direction
BOUND = 1  # of h + w, below which a node penetrates

GAP_STATE_LENGTH = 2


def padded_length(length: int) -> int:
    """Smallest multiple of `CHUNK` that holds `length` values."""
    return -(-length // CHUNK) * CHUNK
