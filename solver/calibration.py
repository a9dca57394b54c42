"""The fitted numbers in estimated errors: all of them, from `calibration.json`, which `linecontact study calibration`
writes.
"""

import json
from dataclasses import dataclass
from pathlib import Path

FILE = Path(__file__).with_name("calibration.json")


@dataclass
class Calibration:
    """The numbers, by their names in the file. They are meant to let 97 of 100 estimates of other scenes hold."""

    of_difference: float
    """Error of an end by pressures, over the power 3/2 of the larger difference of two estimates at the patch's ends,
    times the root of its nodes over `Indenter.steepness`, or of the thickness if that is less [grid spacings]."""
    of_size: float
    """The same times the square of these nodes [grid spacings],"""
    of_size_if_wide: float
    """and in patches that are wide beside the layer, times their nodes, over the power with which the pressure grows
    (`EdgeCurve.power`), beside the former [grid spacings]."""
    beside_gap: float
    """Error of an end by pressures, times the square of the nodes of the gap beside it [grid spacings]."""
    of_heights: float
    """Error of an end by a load, over the sixth over the second difference of the heights, or over the squared ratio of
    the fourth to the second if that is more, plus the inverse square of the nodes of the gap beside it [grid
    spacings]."""
    of_heights_at_gaps: float
    """Error of an end by a gap, over the fourth over the second difference of the heights [grid spacings]."""
    always: float
    """Least error of an end by a load or a gap [grid spacings]."""
    of_layer: float
    """Error of an end beside which the layer looks like a half-space, over the cube of the nodes of its patch, times
    the fourth power of the layer's thickness [grid spacings]; if a gap tells it, over the nodes of the gap, times the
    square of the thickness."""
    of_tip: float
    """Error of the ends beside a tip, see `PowerIndenter.end_error`."""
    in_common: float
    """Share of the errors of patches that has the same sign in all."""
    of_nodes_in_peak: float
    """Error of the peak pressure, over it, times the patches and the square of the nodes of each,"""
    of_nodes_in_approach: float
    """and of the approach."""


FITTED = Calibration(**json.loads(FILE.read_text(encoding="utf-8"))["numbers"])
"""Those that the solver takes."""
