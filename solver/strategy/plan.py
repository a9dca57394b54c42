"""What a scene needs for the accuracy asked for: the smallest sufficient model.

The accuracy is relative. A quarter of it goes to the model, the rest to grid and iteration. What is decided here,
before anything is solved, costs well under a millisecond.

Half-space and Winkler foundation are models for the contact area, and for kappa, whose error follows from the area's:
what they leave out of pressures and approach is not known. Collocation gives them all, but not the pressure at the tip
of a profile sharper than a parabola.

Half-space. Its stiffness differs from the layer's by a share e at most. The area then changes by about e, as it would
for such a change of the load, but near full contact by up to (2/pi) sqrt(e) (a sinusoidal indenter,
`closed_forms.westergaard_area`): that change is estimated as sqrt(e). And e is small beside the tolerance, because the
certificate stays the layer's.

No shortcut is taken that layer and indenter do not justify: see `ElasticLayer` and `Indenter` for what they may offer.
"""

import math
from dataclasses import dataclass

from ..layers import ElasticLayer
from ..scene import Scene
from ..solution import Choice
from .errors import DEFAULT_QUANTITY, QUANTITIES, sensitivity
from .small_models import LEAST_EDGE

_LONG_ASPERITY = 100.0  # half-width over thickness above which collocation takes longer than a grid
_FINE = 1e-5  # accuracy that a grid may not reach
_LONGEST_ASPERITY = 600.0  # half-width over thickness above which collocation is not tried even for that
_MOST_ASPERITY = 0.49  # half-widths in the period: beyond, neighbours merge
_MODEL_SHARE = 0.25  # of the accuracy
_LOOSEST = 1e-5  # tolerance


@dataclass(frozen=True)
class Plan:
    """Which models to try, and on which layer."""

    models: tuple[str, ...]
    """'winkler', 'asperity': smaller models to try, in this order, before the grid."""
    layer: ElasticLayer
    """To solve with: the scene's, or a half-space that is as good."""
    choices: tuple[Choice, ...]
    """What has been chosen so far, and why."""


def decide(scene: Scene, accuracy: float, of: str = DEFAULT_QUANTITY) -> Plan:
    """The models worth trying for an accuracy of one of `QUANTITIES`, from what is known without solving anything."""
    quantity = QUANTITIES[of]
    most = min((_MODEL_SHARE * accuracy / sensitivity(quantity, scene)) ** 2, 0.1 * residual(accuracy))
    replacement, choices = _half_space(scene, most) if quantity.of_area else (scene.layer, ())
    layer, thickness, models = scene.layer, scene.layer.thickness / scene.period, []
    half_width = scene.indenter.guessed_half_width(scene.reduced_load, layer, scene.period)
    thin = LEAST_EDGE * thickness < 2 * half_width * accuracy and layer.foundation_modulus(scene.period) < math.inf
    if thin and layer.edge_shift is not None and quantity.of_area:
        models.append("winkler")
    longest = _LONG_ASPERITY if accuracy > _FINE else _LONGEST_ASPERITY
    power = scene.indenter.power_law
    known = power and (power[0] >= 2 or of != "peak-pressure")
    if known and layer.bonded and half_width < min(_MOST_ASPERITY, longest * thickness):
        models.append("asperity")
    return Plan(tuple(models), replacement, choices)


def residual(accuracy: float) -> float:
    """The tolerance on the free residual that goes with an accuracy."""
    return min(max(0.2 * accuracy, 1e-10), _LOOSEST)


def _half_space(scene: Scene, most: float) -> tuple[ElasticLayer, tuple[Choice, ...]]:
    """The half-space in place of the layer, if their stiffnesses differ by less than `most` (relative)."""
    layer = scene.layer
    if math.isinf(layer.thickness):
        return layer, ()
    known = layer.half_space(scene.period)
    if known is None:
        unknown = "by how much a half-space's stiffness differs is not known for this layer"
        return layer, (Choice("layer", "as it is", unknown),)
    half_space, difference = known
    reason = f"its stiffness differs from a half-space's by up to {100 * difference:.1g} %"
    if difference > most:
        return layer, (Choice("layer", "as it is", reason),)
    return half_space, (Choice("layer", "half-space", reason, math.sqrt(difference)),)
