"""Reference kernel in NumPy for every Warp kernel: same names, same arguments, same order.

The kernel tests compare with them, and they are the baseline of the benchmarks. Plain expressions, no attempt at speed.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import layout
from .layout import CHUNK, COLUMNS, PARTS, STRIDE, TOUCHING

Array = NDArray[Any]
Array64 = NDArray[np.float64]


def _chunk_sums(values: Array) -> Array64:
    return np.asarray(values.reshape(-1, CHUNK).sum(axis=1), dtype=np.float64)


def spectral_multiply(coefficient: Array, spectrum: Array) -> None:
    """spectrum *= coefficient, both flat real views of shape (padded,)."""
    spectrum *= coefficient


def _free_force(elastic: Array, velocity: Array, load: Array | int = 1) -> tuple[Array, Array]:
    """Free part of r = load - K u, and the held nodes."""
    r = load - elastic
    held = (velocity == TOUCHING) & (r > 0)
    return np.where(held, r.dtype.type(0), r), held


def net_force(load: Array, elastic: Array, velocity: Array, force: Array, sums: Array64) -> None:
    """Free part f of r = load - K u; sums of f.f, held nodes, v.f and v.v per chunk."""
    force[:], held = _free_force(elastic, velocity, load)
    sums[:] = _chunk_sums(np.concatenate([force * force, held, velocity * force, velocity * velocity]))


def plain_sums(elastic: Array, velocity: Array, sums: Array64) -> None:
    """Sums of f.f, held nodes, v.f and v.v per chunk, for a load of 1."""
    net_force(np.ones_like(elastic), elastic, velocity, np.empty_like(elastic), sums)


def restrict_to_free(force: Array, field: Array, squares: Array64) -> None:
    """Put a field to 0 on held nodes; sums of its squares per chunk."""
    field[force == 0] = 0
    squares[:] = _chunk_sums(field * field)


def fire_control(sums: Array64, acceleration_sums: Array64, s: Array64) -> None:
    """FIRE's power rule on the chunks' sums: sets mix, gain and dt of the next step."""
    force, held, power, velocity = sums.reshape(PARTS, -1).sum(axis=1)
    acceleration = acceleration_sums[: sums.size // PARTS].sum()
    s[layout.HELD] = held
    s[layout.RESIDUAL] = residual = np.sqrt(force / max(s[layout.NUM_POINTS] - held, 1.0))
    if not residual > s[layout.TOLERANCE] or residual > 1e30:
        s[layout.STOPPED], s[layout.MIX], s[layout.GAIN] = 1.0, 0.0, 0.0
        return
    dt, alpha, mix, gain = s[layout.DT], s[layout.ALPHA], 0.0, 0.0
    if power > 0:
        s[layout.N_POSITIVE] += 1
        if s[layout.N_POSITIVE] > s[layout.N_MIN]:
            dt = min(dt * s[layout.F_INC], s[layout.DT_MAX])
            alpha *= s[layout.F_ALPHA]
        mix = 1 - alpha
        ratio = np.sqrt(velocity / max(acceleration, 1e-300))
        gain = min(alpha * ratio, 1 / (dt * s[layout.STIFFEST]))
    else:
        s[layout.N_POSITIVE] = 0
        alpha = s[layout.ALPHA_START]
        if s[layout.ITERATION] > 0:
            dt *= s[layout.F_DEC]
    s[layout.DT] = max(dt, 0.02 * s[layout.DT_MAX])
    s[layout.ALPHA], s[layout.MIX], s[layout.GAIN] = alpha, mix, gain + s[layout.DT]
    s[layout.ITERATION] += 1


def fire_step(acceleration: Array, h: Array, state: Array64, u: Array, v: Array) -> None:
    """v = mix v + gain a, u += dt v, then the wall: u <= h, v = TOUCHING where it was hit."""
    real = u.dtype.type
    v *= real(state[layout.MIX])
    v += real(state[layout.GAIN]) * acceleration
    u += real(state[layout.DT]) * v
    hit = u >= h
    u[hit] = h[hit]
    v[hit] = TOUCHING


def plain_step(elastic: Array, h: Array, state: Array64, u: Array, v: Array) -> None:
    """`fire_step` with the free force, made from K u, as the acceleration."""
    fire_step(_free_force(elastic, v)[0], h, state, u, v)


def advance_response(change: Array, state: Array64, response: Array) -> None:
    """w += step (G d)."""
    response += response.dtype.type(state[layout.STEP]) * change


def _complex(values: Array) -> Array:
    return values.view(np.result_type(values, np.complex64))


def _columns(columns: Array) -> tuple[Array, Array]:
    """The complex columns, shape (R, COLUMNS/2), and the numbers of rows 0 ... R/2."""
    rows = columns[: columns.size // STRIDE * STRIDE].reshape(-1, STRIDE)[:, :COLUMNS]
    return _complex(rows), np.arange(len(rows) // 2 + 1)


def _spectra(spectra: Array, count: int) -> Array:
    """So many of its rows, shape (count, COLUMNS)."""
    return _complex(spectra).reshape(-1, COLUMNS)[:count]


def unpack_columns(near: Array, far: Array, columns: Array, spectra: Array) -> None:
    """Spectra of two real columns from that of the complex one, times their twiddle factors; see `warp_columns`."""
    values, k = _columns(columns)
    here, mirrored = values[k], values[-k].conj()
    both = np.stack([here + mirrored, (here - mirrored) * -1j], axis=-1) / 2
    _spectra(spectra, k.size)[:] = both.reshape(k.size, -1) * _spectra(near, k.size) * _complex(far)[: k.size, None]


def pack_columns(near: Array, far: Array, spectra: Array, columns: Array) -> None:
    """The way back, without a factor 2."""
    values, k = _columns(columns)
    turned = _spectra(spectra, k.size) * (_spectra(near, k.size) * _complex(far)[: k.size, None]).conj()
    first, second = turned[:, ::2], turned[:, 1::2]
    values[k], values[-k] = first + 1j * second, first.conj() + 1j * second.conj()
