"""Checks of what a scene's layer and indenter say of themselves; those of one's own may say anything.

What they compute, stiffnesses and heights, is checked where it is used (`grid.problem`).
"""

import math
from collections.abc import Mapping
from contextlib import suppress
from numbers import Real
from typing import Any

import numpy as np

from . import checks
from .indenters import INDENTERS, Indenter
from .layers import LAYERS, ElasticLayer
from .layers.tabulated import CLOSE

_LONG = (1e-3, 1e-6, 1e-9)
"""Long waves, over those of the longer of period and thickness; rounding may spoil K of the longest."""


def check_layer(layer: ElasticLayer, period: float) -> None:
    """Raise `ValueError` unless this is a layer for the period L [length]."""
    if not isinstance(layer, ElasticLayer):
        raise ValueError(f"layer is {layer!r}; allowed: a Layer, or what inherits from `ElasticLayer`")
    checks.real("thickness", getattr(layer, "thickness", None), "a length > 0, or inf", 0, infinite=True)
    _check_description("layer", layer, LAYERS)
    checks.real(f"contact_modulus of layer {layer.name}", layer.contact_modulus, "a finite pressure > 0", 0)
    layer.check(period)


def check_foundation(layer: ElasticLayer, period: float) -> None:
    """Raise `ValueError` unless a layer's foundation modulus is one, and K of some long waves if it is one's own."""
    what, allowed = f"foundation_modulus of layer {layer.name}", "a number >= 0, inf where it is incompressible"
    modulus = checks.real(what, layer.foundation_modulus(period), allowed, checks.BELOW_ZERO, infinite=True)
    if type(layer).__module__.startswith(f"{__package__}."):
        return
    periods = float(layer.thickness) / period
    waves = 2 * np.pi * np.array([1.0, *(one / max(periods if periods < math.inf else 1.0, 1.0) for one in _LONG)])
    found = np.full(waves.shape, np.nan)
    with np.errstate(all="ignore"), suppress(Exception):  # one's own code: what is wrong is said where it is used
        found[:] = layer.stiffness(waves, period)
    longest, *long_waves = found.tolist()
    known = [value for value in long_waves if math.isfinite(value) and value != longest]  # a layer may cut off there
    if 0 < modulus < math.inf:
        wrong = bool(known) and all(abs(value / modulus - 1) > CLOSE for value in known)
    else:  # there is no limit to compare with, but a stiffness that hardly changes has a finite one
        alike = all(abs(value - known[0]) <= CLOSE * known[0] for value in known)
        wrong = len(known) > 1 and known[0] > 0 and alike
    if wrong:
        at = ", ".join(f"{wave:.3g}" for wave in waves[1:])
        told = ", ".join(f"{value:.4g}" for value in long_waves)
        allowed = "the limit of its stiffness for long waves, in units of E*/L"
        raise ValueError(f"{what} is {modulus:.6g}, and its stiffness at q L = {at} is {told}; allowed: {allowed}")


def check_indenter(indenter: Indenter, num_points: int, period: float) -> None:
    """Raise `ValueError` unless this is an indenter for a grid of so many points, and for the period L [length]."""
    if not isinstance(indenter, Indenter):
        allowed = "a PowerIndenter, RoughIndenter or MeasuredIndenter, or what inherits from `Indenter`"
        raise ValueError(f"indenter is {indenter!r}; allowed: {allowed}")
    _check_description("indenter", indenter, INDENTERS)
    wave, allowed = indenter.shortest_wave(num_points), "an integer >= 0, 0 for a smooth profile"
    checks.integer(f"shortest_wave of indenter {indenter.name}", wave, allowed, 0, 2**53)
    own = indenter.given_period
    if own is not None:
        own = checks.real(f"given_period of indenter {indenter.name}", own, "a finite length > 0, or None", 0)
        if not math.isclose(period, own):
            raise ValueError(f"period is {period:.10g}; allowed: {own:.10g}, for which the heights were given")
    indenter.check(num_points)


def _check_description(what: str, part: Any, listed: Mapping[str, type]) -> None:
    """Raise `ValueError` unless a part has a name of its own and a description that can be stored."""
    name = getattr(part, "name", None)
    if not isinstance(name, str) or not name:
        raise ValueError(f"name of {what} is {name!r}; allowed: a text that is not empty")
    owner = listed.get(name)
    if owner and not isinstance(part, owner) and owner.__module__.startswith(f"{__package__}."):
        raise ValueError(f"name of {what} is {name!r}, which is that of {owner.__name__}; allowed: another one")
    described, key = part.to_dict(), {"layer": "layer", "indenter": "profile"}[what]
    if not isinstance(described, Mapping) or described.get(key) != name:
        allowed = f"a dictionary with {name!r} under {key!r}"
        raise ValueError(f"to_dict of {what} {name} gives {str(described)[:60]}; allowed: {allowed}")
    for key, value in described.items():
        several = value if isinstance(value, list | tuple) else [value]
        if any(not isinstance(one, (str, Real, np.bool_)) for one in several):
            allowed = "a number, a text, True or False, or several of them"
            raise ValueError(f"to_dict of {what} {name} has {key} {repr(value)[:40]}; allowed: {allowed}")
