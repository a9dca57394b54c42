"""Whether a variant and the reference kernel agree, so strictly that one wrong node is found.

Kernels are compared on values for which none of them rounds anything (multiples of 1/8 up to 2): the results are the
same to the last bit, sums in any order among them. With a transform in between there is rounding, and a node within
that of the wall may be on it or not.
"""

from collections.abc import Mapping

import numpy as np
from linecontact.kernels import layout
from numpy.typing import NDArray

from .benchmark import Argument, Array

_NEGLIGIBLE = 2.0**-40
"""The most that markers of nodes on the wall add to a sum; a wrong node changes it by more."""


def compare(
    variant: str, argument: Argument, found: Mapping[str, Array], expected: Mapping[str, Array], transforms: bool
) -> None:
    """Raise `RuntimeError` if an array of a variant is wrong.

    found, expected: all arrays by name; transforms: whether there is a transform in the benchmark.
    """
    given, wanted = found[argument.name], expected[argument.name]
    if argument.role == "sum":
        given, wanted = _same_chunks(given, wanted)
    elif argument.per_point:
        given = given[: wanted.size]
    if np.array_equal(given, wanted):
        return
    bound = (
        _bound(argument, wanted, expected)
        if transforms
        else np.full(wanted.shape, _NEGLIGIBLE if argument.role == "sum" else 0.0)
    )
    wrong = ~(np.abs(given - wanted) <= bound)
    if transforms and argument.name == "v":
        wrong = _wrong_velocities(found, expected, float(bound[0]))
    if wrong.any():
        first = int(np.argmax(wrong))
        raise RuntimeError(
            f"{variant} and numpy disagree in {int(wrong.sum())} of {wanted.size} values of {argument.name}: "
            f"number {first} is {given[first]} instead of {wanted[first]}"
        )


def _same_chunks(given: Array, wanted: Array) -> tuple[Array, Array]:
    """Both sums over the longer ones of the two kinds of chunks."""
    count = min(given.size, wanted.size)
    return given.reshape(count, -1).sum(axis=1), wanted.reshape(count, -1).sum(axis=1)


def _bound(argument: Argument, wanted: Array, expected: Mapping[str, Array]) -> Array:
    """The error that rounding explains after transforms, value by value.

    Of a value per point some eps log2(N) of the largest; of a sum over a chunk as much of the largest term for each of
    its points, and one node near the wall; of numbers made of the sums some times that, relatively.
    """
    per_point = max(expected.values(), key=lambda array: array.size)
    relative = 30 * float(np.finfo(per_point.dtype).eps) * float(np.log2(per_point.size))
    if argument.role == "control":
        return 10 * relative * np.abs(wanted)
    if argument.role != "sum":
        return np.full(wanted.shape, relative * max(1.0, float(np.abs(wanted).max())))
    largest = max(float(np.abs(array).max()) for name, array in expected.items() if name in _TERMS)
    bound = np.full(wanted.shape, layout.CHUNK * relative * max(1.0, largest**2))
    if argument.name == "sums":
        bound.reshape(layout.PARTS, -1)[layout.HOLDING] += 1
    return bound


_TERMS = ("force", "elastic", "v", "acceleration")
"""Arrays whose products are summed."""


def _wrong_velocities(found: Mapping[str, Array], expected: Mapping[str, Array], bound: float) -> NDArray[np.bool_]:
    """Nodes whose velocities differ, unless both displacements are within rounding of the wall."""
    (u, v), (wanted_u, wanted_v) = ((arrays["u"], arrays["v"]) for arrays in (found, expected))
    near = (np.abs(u - expected["h"]) <= bound) & (np.abs(wanted_u - expected["h"]) <= bound)
    marked = (v == layout.TOUCHING) != (wanted_v == layout.TOUCHING)
    return np.asarray((marked | ~(np.abs(v - wanted_v) <= bound)) & ~near)
