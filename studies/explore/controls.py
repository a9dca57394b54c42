"""The sliders: which numbers of a scene they move, and how far."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from linecontact.solver import Scene

from ..figures.units import Shown

HALF_SPACE = "half-space"
_DIGITS = 3  # of a number from a logarithmic slider: its steps are 5 %


@dataclass(frozen=True)
class Control:
    """A slider. Its position is the number that it moves, dimensionless or in a unit, or that number's logarithm."""

    name: str
    """Of the field that it moves, as on the command line."""
    part: str
    """Of the scene that has the field: 'layer', 'indenter', or 'scene' itself."""
    title: str
    """Its name on the page."""
    low: float
    """Lowest position, unless the scene at the start is lower."""
    high: float
    """Highest position, unless the scene at the start is higher."""
    step: float
    """Distance of two positions."""
    logarithmic: bool = False
    """Whether positions are decimal logarithms."""
    endless: bool = False
    """Whether one position more, at the end, stands for infinity."""
    unit: float | None = None
    """The unit that the number is shown in, in the scene's; None: it is dimensionless."""

    def scale(self, scene: Scene) -> float:
        """The divisor of the field's number: its unit, else the period L [length], E* [pressure], or 1."""
        if self.unit:
            return self.unit
        if self.name == "thickness":
            return scene.period
        return scene.layer.contact_modulus if self.name == "pressure" else 1.0

    def shown_as(self, shown: Shown, scene: Scene) -> "Control":
        """The same slider, of lengths or pressures of a scene, as these are shown."""
        if not shown.unit:
            return self
        shift = math.log10(self.scale(scene) * shown.factor)
        low, high = math.floor(self.low + shift), math.ceil(self.high + shift)
        title = self.title.partition("/")[0] + shown.symbol
        return replace(self, title=title, low=low, high=high, unit=1 / shown.factor)

    def span(self, values: Iterable[float]) -> tuple[float, float]:
        """Lowest and highest position of a slider on which all these numbers, divided by `scale`, have a place."""
        places = [self._place(value) for value in values if math.isfinite(value)]
        if self.logarithmic and places:  # the load: decades about the one that was given
            places = [end for place in places for end in (math.floor(place), math.ceil(place))]
        return min([self.low, *places]), max([self.high, *places])

    def position(self, value: float, high: float) -> float:
        """Where a number, divided by `scale`, stands on a slider that ends at `high`."""
        return self._place(value) if math.isfinite(value) else high + self.step

    def value(self, position: float, high: float) -> float:
        """The number, divided by `scale`, at a position of a slider that ends at `high`."""
        if self.endless and position > high + self.step / 2:
            return math.inf
        if self.logarithmic:
            return float(f"{10**position:.{_DIGITS}g}")
        return round(position, 6) if self.step % 1 else round(position)

    def _place(self, value: float) -> float:
        return math.log10(value) if self.logarithmic else value


THICKNESS = Control("thickness", "layer", "thickness d/L (dimensionless)", -5, 1, 0.02, logarithmic=True, endless=True)
LOAD = Control("pressure", "scene", "mean pressure p/E* (dimensionless)", -6, -1, 0.02, logarithmic=True)

CONTROLS = (
    THICKNESS,
    Control("poisson_ratio", "layer", "Poisson's ratio nu (dimensionless)", 0, 0.5, 0.01),
    LOAD,
    Control("exponent", "indenter", "exponent n (dimensionless)", 1.1, 8, 0.05),
    Control("hurst", "indenter", "Hurst exponent H (dimensionless)", 0.05, 1, 0.01),
    Control("seed", "indenter", "seed of the random phases", 0, 99, 1),
)
"""All of them, in the order of the page; one whose field a scene's layer or indenter lacks is not shown."""
