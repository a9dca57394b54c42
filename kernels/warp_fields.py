"""Warp kernels on fields and their transforms, float32 and float64 from one generic source; on their form, see
`compiled`.

A complex half spectrum is passed as its flat real view (re, im, re, im, ...), because Warp has no complex type. The
kernels of the active set work on the response w = G sigma; a node's gap is h + w - level.
"""

from typing import Any

import warp as wp

from .layout import BOUND, CHUNK, STEP

wp.set_module_options({"enable_backward": False})

Field = wp.array[Any]
Doubles = wp.array[wp.float64]
CHUNK_LENGTH = wp.constant(CHUNK)
LANES = wp.constant(1)
SPAN = wp.constant(CHUNK)


@wp.kernel
def spectral_multiply(coefficient: Field, spectrum: Field):
    """spectrum *= coefficient on the flat real view; the coefficient of a mode stands there twice (re, im)."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        spectrum[i] = coefficient[i] * spectrum[i]


@wp.kernel
def advance_response(change: Field, state: Doubles, response: Field):
    """w += step (G d): the response w = G sigma follows a step along the direction d; the gap is h + w - level.

    In mixed precision the change is float32 and the response float64.
    """
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    step = response.dtype(state[STEP])
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        response[i] = response[i] + step * response.dtype(change[i])


@wp.kernel
def count_below(response: Field, h: Field, state: Doubles, counts: Doubles):
    """Nodes of the chunk where h + w is below the bound."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    bound = h.dtype(state[BOUND])
    count = h.dtype(0.0)
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        count += wp.where(h[i] + response[i] < bound, h.dtype(1.0), h.dtype(0.0))
    counts[tid] = wp.float64(count)
