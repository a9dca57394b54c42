"""The search for the contact nodes in both of its forms, by pressures and by displacements: limits, and earlier sets.

All numbers are dimensionless.
"""

from dataclasses import dataclass, field

SAFETY = 0.2
"""Residual to stop at over the tolerance: the free residual is mostly up to four times the pressure's error."""
HARDER = 0.2
"""Factor of the residual to stop at after the certificate found the free residual too large."""
MOST_ITERATIONS = 150
"""On one set; where it takes more, rounding keeps the residual up."""

_BOLD, _CAUTIOUS = 0.05, 1e-4  # forcing terms


@dataclass
class History:
    """The sets that a search has had. It is bold until one comes back."""

    cautious: bool = False
    """Whether every set is solved well before it is updated."""
    keys: set[int] = field(default_factory=set)
    """Of the sets since it began, or became cautious."""

    @property
    def forcing_term(self) -> float:
        """Part of a new set's residual at which the set is updated."""
        return _CAUTIOUS if self.cautious else _BOLD

    def settles(self, key: int) -> bool:
        """Note a new set; False if it comes back although the search is cautious."""
        if key in self.keys:
            if self.cautious:
                return False
            self.cautious, self.keys = True, set()
        self.keys.add(key)
        return True
