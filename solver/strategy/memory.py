"""Whether a grid fits into the machine's memory, known before it is made."""

from .. import checks
from ..methods import DEFAULT, MethodKind


def check_memory(
    num_points: int, kind: MethodKind = DEFAULT, contact_share: float = 0.0, available: int | None = None
) -> None:
    """Raise `ValueError` for a grid that the free memory cannot hold.

    kind: the method; contact_share: of the nodes, where a coarser grid tells it (dimensionless). available: what was
    free before the solve began [bytes]; by default what is free now.
    """
    available = checks.available_memory() if available is None else available
    needed = kind.bytes_per_point(contact_share) * num_points
    if available is not None and needed > available:
        raise ValueError(
            f"num_points is {num_points}, needing about {needed / 2**30:.1f} GiB; allowed: what fits into the "
            f"{available / 2**30:.1f} GiB that are free"
        )
