"""How the search for the set of contact nodes is getting on: when the set is updated, and when there is no hope."""

import math
from dataclasses import dataclass, field

from .few_at_a_time import FewAtATime

SAFETY = 0.4
"""Residual to stop at over the tolerance: the free residual is up to twice the pressure's error (dimensionless)."""
LOOSEST = 1e-3
"""Tolerance on coarse grids (dimensionless)."""
HARDER = 0.2
"""Factor of the residual to stop at after the certificate found the free residual too large (dimensionless)."""
MOST_ITERATIONS = 150
"""On one set; where it takes more, rounding keeps the residual up."""

_FORCING_TERM = 0.05  # residual of a set over that when it was new, at which it is updated
_MANY_PATCHES, _OF_MANY = 1000, 0.01  # patches that disturb each other, and the forcing term for more of them
_SLOW = 3  # updates without progress after which nodes beyond those that penetrate are added, too
_PROGRESS = 0.8  # an update that changes fewer nodes than this share of the fewest so far counts as progress
_FARTHEST = 63  # nodes that are then added on either side of each one
_PATIENCE, _TIGHT = 8, 1e-3  # updates without progress before the forcing term falls, and its lowest value then
_LESS, _PULL_AGAIN = 2, 0.05  # and among many patches, where a larger share of the nodes than this pulls every time
_LOST = 1e-3  # residual over p with which a search that ends has failed
_UPDATES = 20  # of which a dozen are usual, after which one with such a residual has failed unless it makes progress,
_EARLY, _PULLING = 3, 0.25  # or after fewer under a stiff coating, if more than this share of the nodes pulls
_TOO_MANY = 40  # updates after which a search has failed that is not nearly there
_NEARLY, _ANYWAY = 1e-4, 200  # residual over p of one that is, and updates after which it has failed, too
_TIGHTER, _TIGHTEST = 0.1, 1e-7  # factor of the forcing term when a set comes back, and where the search gives up


@dataclass
class Search:
    """How the search for the set of contact nodes is getting on."""

    forcing_term: float = _FORCING_TERM
    """Part of a new set's residual at which it is updated (dimensionless)."""
    many: bool = False
    """Whether it has begun among many patches."""
    moves_left: int = 0
    """Updates that may still move the ends of patches to where the pressure says that they belong."""
    earlier: set[int] = field(default_factory=set)
    """Keys of the sets so far."""
    fewest: float = math.inf
    """Nodes that an update has dropped and added at the least."""
    few_at_a_time: FewAtATime | None = None
    """How a search that has begun anew is getting on."""
    reach: int = 0
    """Nodes that are added on either side of each one that penetrates."""
    farthest: int = _FARTHEST
    """The most of them."""
    updates: int = 0
    """Updates of the set so far."""
    pulling: float = 0.0
    """Share of the nodes that pulled when the set was last updated (dimensionless)."""
    circling: bool = False
    """Whether sets go round in circles."""
    in_vain: int = 0
    """Updates since that became much less."""

    @classmethod
    def among(cls, num_patches: int) -> "Search":
        """A search that begins with so many patches."""
        return cls(_OF_MANY, many=True) if num_patches > _MANY_PATCHES else cls()

    def may_move_ends(self) -> bool:
        """Whether this update may; one less may after it."""
        self.moves_left -= 1
        return self.moves_left >= 0

    def note(self, changed: int, pulling: float = 0.0) -> None:
        """Note how many nodes an update drops and adds; while that does not become less, solve more accurately.

        pulling: share of the set's nodes that pull (dimensionless).
        """
        self.updates, self.pulling = self.updates + 1, pulling
        if changed < _PROGRESS * self.fewest:
            self.fewest, self.in_vain = changed, 0
            return
        self.in_vain += 1
        patience = _LESS if self.many and pulling > _PULL_AGAIN else _PATIENCE
        if self.in_vain >= patience and self.forcing_term > _TIGHT:
            self.forcing_term, self.in_vain = max(_TIGHT, self.forcing_term * _TIGHTER), 0

    def reach_out(self, dropped: int, added: int) -> int:
        """How many nodes to add on either side of each one that penetrates: 1, 3, 7, ... while ends of patches go
        outwards by a node with every update, as they do on layers whose response is as short as a grid spacing. Where
        that was too far, it begins anew with half as many at the most.
        """
        if self.reach and dropped > added:
            self.farthest, self.reach = self.reach // 2, 0
        elif self.in_vain >= _SLOW:
            if self.in_vain % _PATIENCE == 0:  # solutions are accurate, and other ends may be far away yet
                self.farthest = min(2 * self.farthest + 1, _FARTHEST)
            self.reach = min(2 * self.reach + 1, self.farthest)
        return self.reach

    def in_circles(self, key: int) -> bool:
        """Note a new set; True if sets keep coming back although they are decided on ever more accurate solutions."""
        came_back = key in self.earlier
        if came_back:  # decided on too rough a solution, or really going round in circles
            self.forcing_term *= _TIGHTER
            self.earlier.clear()
        self.earlier.add(key)
        return came_back and self.forcing_term < _TIGHTEST

    def has_failed(self, residual: float, tolerance: float, ended: bool, early: bool) -> bool:
        """Whether the search has failed: by the residual over p that it ended with, by how many updates it has taken,
        whether they still make progress and how many nodes pull, or because it goes round in circles.

        ended: whether it would end here; early: whether many nodes that pull are a sign of it.
        """
        lost = not residual <= max(_LOST, tolerance)
        soon = early and self.updates > _EARLY and self.pulling > _PULLING
        late = self.updates > _UPDATES and self.in_vain > 0
        too_many = self.updates > (_ANYWAY if residual <= _NEARLY else _TOO_MANY)
        return (lost and (ended or soon or late)) or too_many or self.circling
