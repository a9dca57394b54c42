"""Whether a grid fits into the machine's memory, known before it is made."""

from .. import checks
from ..methods import DEFAULT, MethodKind


def check_memory(num_points: int, kind: MethodKind = DEFAULT, contact_share: float = 0.0) -> None:
    """Raise `ValueError` for a grid that the free memory cannot hold.

    kind: the method; contact_share: of the nodes, where a coarser grid tells it (dimensionless).
    """
    available, needed = checks.available_memory(), kind.bytes_per_point(contact_share) * num_points
    if available is not None and needed > available:
        raise ValueError(
            f"num_points is {num_points}, needing about {needed / 2**30:.1f} GiB; allowed: what fits into the "
            f"{available / 2**30:.1f} GiB that are free"
        )
