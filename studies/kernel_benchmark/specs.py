"""What the benchmark knows of every kernel: its arrays, what they hold, its floating-point operations, and C's loop.

A kernel that changes its arguments changes its line here and its twin in `elements`; nothing else knows signatures.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from linecontact.kernels import CHUNK, layout
from numpy.typing import NDArray

Array = NDArray[Any]

READS = ("in", "part", "state")
"""Roles of inputs; all others are outputs."""


class Argument(NamedTuple):
    """An array of a kernel."""

    name: str
    """As the kernel calls it."""
    role: str
    """'in', 'out' and 'inout' hold one value per point, 'part' (read) and 'sum' (written) one float64 per chunk,
    'state' (read) and 'control' (read and written) float64 scalars."""

    @property
    def per_point(self) -> bool:
        """Whether it holds one value per point, in the precision asked for; all else is float64."""
        return self.role in ("in", "out", "inout")

    def size(self, num_points: int) -> int:
        """Number of values that it holds."""
        if self.per_point:
            return num_points
        return num_points // CHUNK if self.role in ("part", "sum") else layout.STATE_LENGTH

    def dtype(self, precision: str) -> str:
        """Type of its values."""
        return precision if self.per_point else "float64"

    def size_bytes(self, num_points: int, precision: str) -> int:
        """Memory that it takes [byte]; that of scalars is not counted."""
        if self.role in ("state", "control"):
            return 0
        return self.size(num_points) * np.dtype(self.dtype(precision)).itemsize

    def make(self, num_points: int, precision: str, rng: np.random.Generator) -> Array:
        """Make values like the solver's: forces of both signs, a third of the nodes on the wall, no decay."""
        size = self.size(num_points)
        values = rng.standard_normal(size)
        on_wall = rng.random(size) < 0.3
        if not self.per_point:
            values = np.abs(values)
        elif self.name in _VALUES:
            values = _VALUES[self.name](values, on_wall)
        return values.astype(self.dtype(precision))


_VALUES: dict[str, Callable[[Array, Array], Array]] = {
    "coefficient": lambda x, _: np.sign(x) * (1 + 0.02 * np.tanh(x)),  # multiplied in again and again
    "velocity": lambda x, wall: np.where(wall, layout.TOUCHING, x),
    "v": lambda x, wall: np.where(wall, layout.TOUCHING, x),
    "force": lambda x, wall: np.where(wall, 0.0, x),
    "h": lambda x, _: np.abs(x),
    "u": lambda x, _: -np.abs(x),
}


@dataclass(frozen=True)
class Spec:
    """What the benchmark knows of a kernel."""

    arguments: str
    """'name:role ...' in the kernel's order."""
    flops: int
    """Floating-point operations per point, comparisons not counted."""
    c: str = ""
    """Body of the loop over i in C, where a 'sum' is a scalar; empty for a kernel without a loop over points."""
    c_scalars: str = ""
    """What C reads from the state before the loop."""
    state: dict[str, float] = field(default_factory=dict)
    """Values of the state by the names of their slots."""

    @property
    def arrays(self) -> list[Argument]:
        """The arguments, one by one."""
        return [Argument(*text.split(":")) for text in self.arguments.split()]

    def traffic(self, num_points: int, precision: str) -> int:
        """Bytes that a call reads and writes: each array once, and twice what is changed in place."""
        return sum((1 + (a.role == "inout")) * a.size_bytes(num_points, precision) for a in self.arrays)

    def working_set(self, num_points: int, precision: str) -> int:
        """Bytes of all arrays."""
        return sum(a.size_bytes(num_points, precision) for a in self.arrays)

    def make(self, num_points: int, precision: str) -> list[Array]:
        """Make the values of every array; outputs that are not read are zeros."""
        rng = np.random.default_rng(0)
        made = [argument.make(num_points, precision, rng) for argument in self.arrays]
        for argument, values in zip(self.arrays, made, strict=True):
            if argument.role in ("state", "control"):
                values[:] = 0
                for slot, value in self.state.items():
                    values[getattr(layout, slot)] = value
            elif argument.role in ("out", "sum"):
                values[:] = 0
        return made


_STEP = {"MIX": 0.9, "GAIN": 0.1, "DT": 0.25}
_STEP_SCALARS = "REAL mix = state[MIX], gain = state[GAIN], dt = state[DT];"
_FORCE = "REAL r = {load} - elastic[i]; int on_wall = ({v} == (REAL)TOUCHING) & (r > 0); REAL f = on_wall ? 0 : r;"
_WALL = """
    REAL w = mix * v[i] + gain * {a}, x = u[i] + dt * w;
    int hit = x >= h[i];
    u[i] = hit ? h[i] : x;
    v[i] = hit ? (REAL)TOUCHING : w;"""

SPECS = {
    "spectral_multiply": Spec("coefficient:in spectrum:inout", 1, "spectrum[i] *= coefficient[i];"),
    "mirror_multiply": Spec(
        "straight:in crossed:in spectrum:inout",
        3,
        """if (i < n / 2) {  // gcc splits the loop there
        long k = 2 * i;
        REAL re = spectrum[k], im = spectrum[k + 1];
        spectrum[k] = straight[k] * re + crossed[k] * im;
        spectrum[k + 1] = straight[k + 1] * im + crossed[k + 1] * re;
    }""",
    ),
    "net_force": Spec(
        "load:in elastic:in velocity:in force:out force_sums:sum held_sums:sum",
        4,
        _FORCE.format(load="load[i]", v="velocity[i]") + "force[i] = f; force_sums += f * f; held_sums += on_wall;",
    ),
    "search_sums": Spec(
        "force:in velocity:in acceleration:inout power_sums:sum velocity_sums:sum acceleration_sums:sum",
        6,
        """REAL f = force[i], v = velocity[i], a = f == 0 ? 0 : acceleration[i];
    acceleration[i] = a; power_sums += v * f; velocity_sums += v * v; acceleration_sums += a * a;""",
    ),
    "restrict_to_free": Spec(
        "force:in field:in restricted:out squares:sum",
        2,
        "REAL x = force[i] == 0 ? 0 : field[i]; restricted[i] = x; squares += x * x;",
    ),
    "fire_control": Spec(
        "force_sums:part held_sums:part power_sums:part velocity_sums:part acceleration_sums:part state:control",
        0,
        state={"DT_MAX": 1.0, "N_MIN": 2, "F_INC": 1.1, "F_DEC": 0.5, "ALPHA_START": 0.1, "F_ALPHA": 0.99}
        | {"STIFFEST": 2.0, "NUM_POINTS": 2.0**30, "DT": 0.4, "ALPHA": 0.05},
    ),
    "fire_step": Spec(
        "acceleration:in h:in state:state u:inout v:inout",
        5,
        _WALL.format(a="acceleration[i]"),
        _STEP_SCALARS,
        _STEP,
    ),
    "plain_sums": Spec(
        "elastic:in velocity:in force_sums:sum held_sums:sum power_sums:sum velocity_sums:sum",
        8,
        _FORCE.format(load="1", v="velocity[i]")
        + """REAL v = velocity[i];
    force_sums += f * f; held_sums += on_wall; power_sums += v * f; velocity_sums += v * v;""",
    ),
    "plain_step": Spec(
        "elastic:in h:in state:state u:inout v:inout",
        6,
        _FORCE.format(load="1", v="v[i]") + _WALL.format(a="f"),
        _STEP_SCALARS,
        _STEP,
    ),
    "advance_response": Spec(
        "change:in state:state response:inout",
        2,
        "response[i] += step * change[i];",
        "REAL step = state[STEP];",
        {"STEP": 0.7},
    ),
    "count_below": Spec(
        "response:in h:in state:state counts:sum",
        2,
        "counts += h[i] + response[i] < bound;",
        "REAL bound = state[BOUND];",
        {"BOUND": 0.1},
    ),
    "rest_on_wall": Spec(
        "response:in h:in state:state u:out",
        1,
        "REAL x = level - response[i]; u[i] = x < h[i] ? x : h[i];",
        "REAL level = state[LEVEL];",
        {"LEVEL": 0.4},
    ),
}
"""By kernel, in the order of `linecontact.kernels.KERNELS`."""
