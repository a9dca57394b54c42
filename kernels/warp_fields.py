"""Warp kernels on fields and their transforms, float32 and float64 from one generic source; on their form, see
`compiled`.

A complex half spectrum is passed as its flat real view (re, im, re, im, ...), because Warp has no complex type.
"""

from typing import Any

import warp as wp

from .layout import CHUNK, STEP

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
    """w += step (G d): the response w = G sigma follows a step along the direction d; the gap is h + w - level."""
    tid = wp.tid()
    start = tid // LANES * SPAN + tid % LANES
    step = response.dtype(state[STEP])
    for j in range(CHUNK_LENGTH):
        i = start + j * LANES
        response[i] = response[i] + step * change[i]
