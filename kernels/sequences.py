"""The sequences of kernels that the methods launch between two transforms, by name.

A line of a sequence is a kernel with the names of its inputs and, behind the arrow, of its outputs, in the kernel's
order. Sums have one value per chunk, or `layout.PARTS`.
"""

from collections.abc import Mapping

from .record import Array, Call

SEQUENCES = {
    "plain_move": (
        "plain_sums: elastic v -> sums",
        "fire_control: sums sums -> state",  # the force is the acceleration
        "plain_step: elastic h state -> u v",
    ),
    "loaded_move": (
        "net_force: load elastic v -> force sums",
        "fire_control: sums sums -> state",
        "fire_step: force h state -> u v",
    ),
    "find_force": ("net_force: load elastic v -> force sums",),
    "mass_weighted_move": (
        "restrict_to_free: force -> acceleration acceleration_sums",
        "fire_control: sums acceleration_sums -> state",
        "fire_step: acceleration h state -> u v",
    ),
}
"""Plain FIRE's step from K u; the same with a load that differs from node to node; of mass-weighted FIRE the force, and
the step from it and the acceleration."""


def parse(text: str) -> Call:
    """The line of a sequence, with names instead of arrays, from a text like "fire_step: h state -> u v"."""
    kernel, _, names = text.partition(":")
    inputs, _, outputs = names.partition("->")
    return Call(kernel, tuple(inputs.split()), tuple(outputs.split()))


def sequence(name: str, arrays: Mapping[str, Array]) -> list[Call]:
    """The launches of a sequence on arrays, by the names that its lines give them."""
    lines = map(parse, SEQUENCES[name])
    return [Call(kernel, *(tuple(arrays[n] for n in names) for names in of)) for kernel, *of in lines]
