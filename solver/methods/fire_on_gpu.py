"""Iterations of FIRE on a GPU: each is one graph, and some are in the queue before the control state is looked at."""

from collections.abc import Callable

import numpy as np

from ...kernels import layout
from ..arrays import Array64
from ..grid.problem import Problem
from ..transforms import on_gpu
from .fire_state import LOOK_AFTER, Fire
from .method import ExecutionConfig

NetForce = Callable[[Array64], Array64]

_SPARE = 7
"""Arrays of N values that cuFFT and a start take beside FIRE's own; in mixed precision the base and its force take
twice as many, in float64."""


class Repetition:
    """Repeats the iterations of a FIRE whose arrays are on the GPU.

    Where the surface lifts off, which is put right at the next look, every iteration is looked at for a while.
    """

    def __init__(self) -> None:
        self._count = 1
        self._graph: Callable[[], None] | None = None

    def __call__(self, fire: Fire, most: int) -> None:
        """Up to `most` iterations, at least one."""
        count = min(most, self._count, -fire.iteration % fire.probe_every)  # up to an iteration that does more
        if count < 2:  # the first of all makes preparations that a graph cannot hold
            fire.step()
        else:
            if self._graph is None:
                self._graph = on_gpu.capture(fire.parts)
            for _ in range(count):
                self._graph()
            fire.transform_pairs += count * fire.pairs_per_iteration
            fire.after_step()
        self._count = min(2 * self._count, LOOK_AFTER) if fire.state[layout.HELD] > fire.padding else 1


def begin(kind: type[Fire], problem: Problem, config: ExecutionConfig) -> tuple[Fire, NetForce]:
    """FIRE of a kind on the GPU, and the net force there in float64, which mixed precision needs.

    Raises `ValueError` for a grid that the GPU's free memory cannot hold.
    """
    mixed, num_points = config.precision == "mixed", problem.num_points
    needed, free = needed_memory(kind, num_points, config.precision), on_gpu.free_memory()
    if needed > free:
        raise ValueError(
            f"num_points is {num_points}, needing about {needed / 2**30:.1f} GiB of the GPU's memory; allowed: what "
            f"fits into the {free / 2**30:.1f} GiB that are free"
        )
    try:
        transforms = on_gpu.Transforms(num_points, config.working_precision)
        fire = kind(problem, transforms, config.tolerance, own_load=mixed)
        net_force = _net_force(problem) if mixed else problem.net_force
    except on_gpu.OutOfMemory as error:  # the transforms of some lengths take many times as much as those of others
        what = f"num_points is {num_points}, too many for the GPU's memory ({error})"
        raise ValueError(f"{what}; allowed: fewer, or products of small primes") from error
    fire.repeat = Repetition()
    return fire, net_force


def _net_force(problem: Problem) -> NetForce:
    """`problem.net_force` on the GPU, in float64."""
    transforms = on_gpu.Transforms(problem.num_points, "float64")
    field = transforms.buffer()
    multiply = transforms.multiplication(problem.stiffness)
    operator = transforms.forward(field), multiply, transforms.inverse(field)

    def net_force(displacement: Array64) -> Array64:
        transforms.put(field, displacement)
        for part in operator:
            part()
        return 1 - field[: problem.num_points]

    return net_force


def needed_memory(kind: type[Fire], num_points: int, precision: str) -> int:
    """The GPU's memory that a solve takes, about [bytes]; transforms of large prime factors take more."""
    size = np.dtype("float64" if precision == "float64" else "float32").itemsize
    return num_points * (size * (kind.buffers + _SPARE) + (2 * 8 * _SPARE if precision == "mixed" else 0))
