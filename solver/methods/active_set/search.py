"""How the search for the set of contact nodes is getting on: when the set is updated, and when it ends."""

import math
from dataclasses import dataclass, field

SAFETY = 0.4
"""Residual to stop at over the tolerance: the free residual is up to twice the pressure's error (dimensionless)."""
LOOSEST = 1e-3
"""Tolerance on coarse grids (dimensionless)."""
HARDER = 0.2
"""Factor of the residual to stop at after the certificate found the free residual too large (dimensionless)."""
MOST_ITERATIONS = 150
"""On one set; where it takes more, rounding keeps the residual up."""

_FORCING_TERM, _CAUTIOUS = 0.05, 1e-4  # residual of a set over that when it was new, at which it is updated
_PROGRESS = 0.8  # an update that changes fewer nodes than this share of the fewest so far counts as progress
_PATIENCE, _TIGHT = 8, 1e-3  # updates without progress before the forcing term falls, and its lowest value then
_TIGHTER, _TIGHTEST = 0.1, 1e-7  # factor of the forcing term when a set comes back, and where the search gives up


@dataclass
class Search:
    """How the search for the set of contact nodes is getting on."""

    cautious: bool = False
    """Whether nodes that penetrate are added only when none pulls, and every set is solved well before it changes."""
    forcing_term: float = field(init=False)
    """Part of a new set's residual at which it is updated (dimensionless)."""
    earlier: set[int] = field(default_factory=set)
    """Keys of the sets so far."""
    fewest: float = math.inf
    """Nodes that an update has dropped and added at the least."""
    in_vain: int = 0
    """Updates since that became much less."""

    def __post_init__(self) -> None:
        self.forcing_term = _CAUTIOUS if self.cautious else _FORCING_TERM

    def note(self, changed: int) -> None:
        """Note how many nodes an update drops and adds; while that does not become less, solve more accurately."""
        if changed < _PROGRESS * self.fewest:
            self.fewest, self.in_vain = changed, 0
            return
        self.in_vain += 1
        if self.in_vain >= _PATIENCE and self.forcing_term > _TIGHT:
            self.forcing_term, self.in_vain = max(_TIGHT, self.forcing_term * _TIGHTER), 0

    def in_circles(self, key: int) -> bool:
        """Note a new set; True if sets keep coming back although they are decided on ever more accurate solutions."""
        came_back = key in self.earlier
        if came_back:  # decided on too rough a solution, or really going round in circles
            self.forcing_term *= _TIGHTER
            self.earlier.clear()
        self.earlier.add(key)
        return came_back and self.forcing_term < _TIGHTEST
