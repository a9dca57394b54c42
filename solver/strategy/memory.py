"""Whether a grid fits into the machine's memory, known before it is made."""

from .. import checks

_BYTES_PER_POINT = 250  # at the peak; measured: 120 (plain FIRE), 135 to 170 (active set), 350 (94 % in contact)


def check_memory(num_points: int) -> None:
    """Raise `ValueError` for a grid that the free memory cannot hold: 20 to 25 arrays of N values at the peak."""
    available, needed = checks.available_memory(), _BYTES_PER_POINT * num_points
    if available is not None and needed > available:
        raise ValueError(
            f"num_points is {num_points}, needing about {needed / 2**30:.1f} GiB; allowed: what fits into the "
            f"{available / 2**30:.1f} GiB that are free"
        )
