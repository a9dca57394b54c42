"""The list of benchmarks: every kernel, the sequences of them that methods launch, whole iterations, transforms,
and the memory itself.

A kernel that changes its arguments changes its line here and its reference kernel in `linecontact.kernels.reference`.
"""

import math
from collections.abc import Callable

from linecontact.kernels import sequences

from .benchmark import Benchmark, compose

GROUPS = ("kernels", "sequences", "iterations", "transforms", "roofs")

ROW = 1024
"""Length of the rows in `rows_pair`, in complex numbers."""


def _per_point(count: float) -> Callable[[int], float]:
    return lambda num_points: count * num_points


def _kernel(name: str, arguments: str, flops: float, c: str, scalars: str = "", **state: float) -> Benchmark:
    return Benchmark(name, "kernels", arguments, _per_point(flops), c, scalars, state=state)


_STEP = {"MIX": 0.75, "GAIN": 0.25, "DT": 0.25}
_STEP_SCALARS = "REAL mix = state[MIX], gain = state[GAIN], dt = state[DT];"
_FORCE = "REAL r = {load} - elastic[i]; int on_wall = ({v} == (REAL)TOUCHING) & (r > 0); REAL f = on_wall ? 0 : r;"
_FIRE_SUMS = """ REAL v = velocity[i];
    sums[FORCE] += f * f; sums[HOLDING] += on_wall; sums[POWER] += v * f; sums[VELOCITY] += v * v;"""
_WALL = """
    REAL w = mix * v[i] + gain * {a}, x = u[i] + dt * w;
    int hit = x >= h[i];
    u[i] = hit ? h[i] : x;
    v[i] = hit ? (REAL)TOUCHING : w;"""
# dt and alpha stay as they are and the stiffest mode limits the gain: the next step's numbers are exact
_CONTROL = {"DT_MAX": 1.0, "N_MIN": 2.0**30, "F_INC": 1.1, "F_DEC": 0.5, "ALPHA_START": 0.25, "F_ALPHA": 0.99}
_CONTROL |= {"STIFFEST": 4096.0, "NUM_POINTS": 2.0**30, "DT": 0.25, "ALPHA": 0.25, "MIX": 0.75, "GAIN": 0.25}
_CONTROL_IN_C = """
    double f = 0, held = 0, p = 0, vv = 0, aa = 0;
    long chunks = n / CHUNK;
    for (long k = 0; k < chunks; k++) {
        f += sums[FORCE * chunks + k]; held += sums[HOLDING * chunks + k]; p += sums[POWER * chunks + k];
        vv += sums[VELOCITY * chunks + k]; aa += acceleration_sums[k];
    }
    double residual = sqrt(f / fmax(state[NUM_POINTS] - held, 1.0));
    state[RESIDUAL] = residual;
    state[HELD] = held;
    if (!(residual > state[TOLERANCE]) || residual > 1e30) {
        state[STOPPED] = 1; state[MIX] = 0; state[GAIN] = 0;
    } else {
        double dt = state[DT], alpha = state[ALPHA], mix = 0, gain = 0;
        if (p > 0) {
            state[N_POSITIVE] += 1;
            if (state[N_POSITIVE] > state[N_MIN]) {
                dt = fmin(dt * state[F_INC], state[DT_MAX]);
                alpha *= state[F_ALPHA];
            }
            mix = 1 - alpha;
            gain = fmin(alpha * sqrt(vv / fmax(aa, 1e-300)), 1 / (dt * state[STIFFEST]));
        } else {
            state[N_POSITIVE] = 0;
            alpha = state[ALPHA_START];
            if (state[ITERATION] > 0) dt *= state[F_DEC];
        }
        state[DT] = fmax(dt, 0.02 * state[DT_MAX]);
        state[ALPHA] = alpha; state[MIX] = mix; state[GAIN] = gain + state[DT];
        state[ITERATION] += 1;
    }"""

_READ = """
    REAL sums[32] = {0};  // several, because an addition takes several cycles
    for (long i = 0; i < n; i += 32) for (int k = 0; k < 32; k++) sums[k] += a[i + k];
    REAL total = 0;
    for (int k = 0; k < 32; k++) total += sums[k];
    for (long k = 0; k < n / CHUNK; k++) total_out[k] = total;"""

_TURN = """
            REAL cos_{c} = far_re * near[q + {q}] - far_im * near[q + {q} + 1];
            REAL sin_{c} = far_re * near[q + {q} + 1] + far_im * near[q + {q}];"""
_TURNS = _TURN.format(c="a", q=0) + _TURN.format(c="b", q=2)
_UNPACK = (
    _TURNS
    + """
            REAL a_re = (REAL)0.5 * (columns[i] + columns[j]), a_im = (REAL)0.5 * (columns[i + 1] - columns[j + 1]);
            REAL b_re = (REAL)0.5 * (columns[i + 1] + columns[j + 1]), b_im = (REAL)0.5 * (columns[j] - columns[i]);
            spectra[q] = a_re * cos_a - a_im * sin_a;
            spectra[q + 1] = a_re * sin_a + a_im * cos_a;
            spectra[q + 2] = b_re * cos_b - b_im * sin_b;
            spectra[q + 3] = b_re * sin_b + b_im * cos_b;"""
)
_PACK = (
    _TURNS
    + """
            REAL a_re = spectra[q] * cos_a + spectra[q + 1] * sin_a, a_im = spectra[q + 1] * cos_a - spectra[q] * sin_a;
            REAL b_re = spectra[q + 2] * cos_b + spectra[q + 3] * sin_b;
            REAL b_im = spectra[q + 3] * cos_b - spectra[q + 2] * sin_b;
            columns[i] = a_re - b_im;
            columns[i + 1] = a_im + b_re;
            columns[j] = a_re + b_im;
            columns[j + 1] = b_re - a_im;"""
)


def _of_columns(name: str, arguments: str, pair: str) -> Benchmark:
    """A kernel on columns of a four-step transform. pair: C's loop for two of them in a row."""
    c = """
    long rows = 2 * (n / (2 * COLUMNS)) - 2;
    for (long k = 0; k <= rows / 2; k++) {{
        REAL far_re = far[2 * k], far_im = far[2 * k + 1];
        for (long c = 0; c < COLUMNS / 2; c++) {{
            long i = k * STRIDE + 2 * c, j = (rows - k) % rows * STRIDE + 2 * c, q = 2 * COLUMNS * k + 4 * c;{pair}
        }}
    }}"""
    return Benchmark(name, "kernels", arguments, _per_point(8), c_whole=c.format(pair=pair))


_KERNELS = (
    _kernel("spectral_multiply", "coefficient:in spectrum:inout", 1, "spectrum[i] *= coefficient[i];"),
    _of_columns("unpack_columns", "near:in far:in columns:in spectra:out", _UNPACK),
    _of_columns("pack_columns", "near:in far:in spectra:in columns:inout", _PACK),
    _kernel(
        "net_force",
        "load:in elastic:in velocity:in force:out sums:sum",
        8,
        _FORCE.format(load="load[i]", v="velocity[i]") + "force[i] = f;" + _FIRE_SUMS,
    ),
    _kernel(
        "restrict_to_free",
        "force:in field:inout squares:sum",
        2,
        "REAL x = force[i] == 0 ? 0 : field[i]; field[i] = x; squares[0] += x * x;",
    ),
    Benchmark(
        "fire_control",
        "kernels",
        "sums:part acceleration_sums:part state:control",
        c_whole=_CONTROL_IN_C,
        state=_CONTROL,
    ),
    _kernel(
        "fire_step",
        "acceleration:in h:in state:state u:inout v:inout",
        5,
        _WALL.format(a="acceleration[i]"),
        _STEP_SCALARS,
        **_STEP,
    ),
    _kernel(
        "plain_sums",
        "elastic:in velocity:in sums:sum",
        8,
        _FORCE.format(load="1", v="velocity[i]") + _FIRE_SUMS,
    ),
    _kernel(
        "plain_step",
        "elastic:in h:in state:state u:inout v:inout",
        6,
        _FORCE.format(load="1", v="v[i]") + _WALL.format(a="f"),
        _STEP_SCALARS,
        **_STEP,
    ),
    _kernel(
        "advance_response",
        "change:in state:state response:inout",
        2,
        "response[i] += step * change[i];",
        "REAL step = state[STEP];",
        STEP=0.75,
    ),
)

_HALVES = (
    Benchmark("forward", "transforms", "source:in spectrum:out", lambda n: 2.5 * n * math.log2(n)),
    Benchmark("inverse", "transforms", "spectrum:inout target:out", lambda n: 2.5 * n * math.log2(n)),
    Benchmark("product", "transforms", "source:in target:out", lambda n: 5 * n * math.log2(n)),
)
"""Real transforms, by the usual count of operations of a complex one, and both ways with a multiplication by 1 in
between; only measured as pairs, or as parts of an iteration."""

_ROWS = Benchmark("rows_pair", "transforms", "rows:inout", lambda n: 5 * n * math.log2(min(ROW, n / 2)))
"""Complex transforms of rows of `ROW` numbers, N/2 in all; in place, there and back."""

_ROOFS = (
    Benchmark("read", "roofs", "a:in total:sum", c_whole=_READ),
    Benchmark("write", "roofs", "a:out", c="a[i] = 1;"),
    Benchmark("copy", "roofs", "a:in b:out", c="b[i] = a[i];"),
    Benchmark("update", "roofs", "a:inout", c="a[i] = -a[i];"),
)
"""Loops that compute nothing, for the rate of the memory; only in C."""

_PAIR = ("forward: source -> spectrum", "inverse: spectrum -> target")
_STIFFNESS = ("forward: u -> spectrum", "spectral_multiply: coefficient -> spectrum", "inverse: spectrum -> elastic")
_INVERSE_MASS = (
    "forward: force -> spectrum",
    "spectral_multiply: weight -> spectrum",
    "inverse: spectrum -> acceleration",
)
_ITERATIONS = {
    "plain_iteration": (*_STIFFNESS, *sequences.SEQUENCES["plain_move"]),
    "four_step_iteration": ("product: u -> elastic", *sequences.SEQUENCES["plain_move"]),
    "loaded_iteration": (*_STIFFNESS, *sequences.SEQUENCES["loaded_move"]),
    "mass_weighted_iteration": (
        *_STIFFNESS,
        *sequences.SEQUENCES["find_force"],
        *_INVERSE_MASS,
        *sequences.SEQUENCES["mass_weighted_move"],
    ),
    "search_step": (
        "forward: source -> spectrum",
        "spectral_multiply: coefficient -> spectrum",
        "inverse: spectrum -> change",
        "advance_response: change state -> response",
    ),
}
"""One iteration of plain FIRE, with real transforms and in four steps, which the program takes from 2^20 points on, of
FIRE in mixed precision, of mass-weighted FIRE, and of the active set's search without its work on the contact nodes
alone.
"""


def _all() -> dict[str, Benchmark]:
    found = {one.name: one for one in (*_KERNELS, *_HALVES)}
    composed = [("sequences", *item) for item in sequences.SEQUENCES.items() if len(item[1]) > 1]
    composed += [("iterations", *item) for item in _ITERATIONS.items()]
    composed += [("transforms", "real_pair", _PAIR)]
    for group, name, texts in composed:
        found[name] = compose(name, group, tuple(map(sequences.parse, texts)), found)
    found |= {one.name: one for one in (_ROWS, *_ROOFS)}
    return {name: one for name, one in found.items() if one not in _HALVES}


BENCHMARKS = _all()
"""By name, group by group."""
