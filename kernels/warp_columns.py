"""Warp kernels between the two halves of a four-step transform, `solver/transforms/four_step.py`, float32 and float64.

N = R C real values stand in R rows of C. Some columns at a time, two of them are taken as one complex column and
transformed; these kernels take the two spectra apart, and turn them by the twiddle factors exp(-2 pi i k c/N) of row k
and column c. A factor is the product of two: that of the column from the first one here, `near`, and that of the first
column, `far`. Of the R spectral rows only R/2 + 1 are needed.

A thread works on the rows that `near` has a chunk for. Complex numbers are (re, im) on flat real views.
"""

from typing import Any

import warp as wp

from .layout import CHUNK, COLUMNS, STRIDE

wp.set_module_options({"enable_backward": False})

Field = wp.array[Any]
CHUNK_LENGTH = wp.constant(CHUNK)
PAIRS = wp.constant(COLUMNS // 2)
COLUMNS_LENGTH = wp.constant(STRIDE)
SPECTRA_LENGTH = wp.constant(2 * COLUMNS)


@wp.func
def times(a_re: Any, a_im: Any, b_re: Any, b_im: Any):
    """Product of two complex numbers."""
    return a_re * b_re - a_im * b_im, a_re * b_im + a_im * b_re


@wp.kernel
def unpack_columns(near: Field, far: Field, columns: Field, spectra: Field):
    """The spectra of two real columns from that of the complex one, each times its twiddle factor."""
    num_rows = columns.shape[0] // COLUMNS_LENGTH
    first = wp.tid() * (CHUNK_LENGTH // SPECTRA_LENGTH)
    last = wp.min(first + CHUNK_LENGTH // SPECTRA_LENGTH, num_rows // 2 + 1)
    half = columns.dtype(0.5)
    for k in range(first, last):
        here = wp.max(k * COLUMNS_LENGTH, 0)  # LLVM must see that no index is negative
        mirrored = wp.max((num_rows - k) % num_rows * COLUMNS_LENGTH, 0)
        row = wp.max(k * SPECTRA_LENGTH, 0)
        far_re, far_im = far[2 * k], far[2 * k + 1]
        for c in range(PAIRS):
            i, j, q = here + 2 * c, mirrored + 2 * c, row + 4 * c
            re, im, mirrored_re, mirrored_im = columns[i], columns[i + 1], columns[j], columns[j + 1]
            a_turn_re, a_turn_im = times(far_re, far_im, near[q], near[q + 1])
            b_turn_re, b_turn_im = times(far_re, far_im, near[q + 2], near[q + 3])
            a_re, a_im = times(half * (re + mirrored_re), half * (im - mirrored_im), a_turn_re, a_turn_im)
            b_re, b_im = times(half * (im + mirrored_im), half * (mirrored_re - re), b_turn_re, b_turn_im)
            spectra[q] = a_re
            spectra[q + 1] = a_im
            spectra[q + 2] = b_re
            spectra[q + 3] = b_im


@wp.func
def turned_back(near: Field, far_re: Any, far_im: Any, spectra: Field, q: int):
    """Two spectra without their twiddle factors."""
    a_turn_re, a_turn_im = times(far_re, far_im, near[q], near[q + 1])
    b_turn_re, b_turn_im = times(far_re, far_im, near[q + 2], near[q + 3])
    a_re, a_im = times(spectra[q], spectra[q + 1], a_turn_re, -a_turn_im)
    b_re, b_im = times(spectra[q + 2], spectra[q + 3], b_turn_re, -b_turn_im)
    return a_re, a_im, b_re, b_im


@wp.kernel
def pack_columns(near: Field, far: Field, spectra: Field, columns: Field):
    """The way back: turned by the conjugate factors, two spectra as that of one complex column, without a factor 2."""
    num_rows = columns.shape[0] // COLUMNS_LENGTH
    first = wp.tid() * (CHUNK_LENGTH // SPECTRA_LENGTH)
    last = wp.min(first + CHUNK_LENGTH // SPECTRA_LENGTH, num_rows // 2 + 1)
    for k in range(first, last):
        here = wp.max(k * COLUMNS_LENGTH, 0)  # LLVM must see that no index is negative
        mirrored = wp.max((num_rows - k) % num_rows * COLUMNS_LENGTH, 0)
        row = wp.max(k * SPECTRA_LENGTH, 0)
        far_re, far_im = far[2 * k], far[2 * k + 1]
        for c in range(PAIRS):
            a_re, a_im, b_re, b_im = turned_back(near, far_re, far_im, spectra, row + 4 * c)
            columns[here + 2 * c] = a_re - b_im
            columns[here + 2 * c + 1] = a_im + b_re
        for c in range(PAIRS):  # again, because loops that write to one place only become vector code
            a_re, a_im, b_re, b_im = turned_back(near, far_re, far_im, spectra, row + 4 * c)
            columns[mirrored + 2 * c] = a_re + b_im
            columns[mirrored + 2 * c + 1] = b_re - a_im
