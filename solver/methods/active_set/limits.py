"""Limits that the search has in both of its forms, by pressures and by displacements; all are dimensionless."""

SAFETY = 0.2
"""Residual to stop at over the tolerance: the free residual is mostly up to four times the pressure's error."""
HARDER = 0.2
"""Factor of the residual to stop at after the certificate found the free residual too large."""
MOST_ITERATIONS = 150
"""On one set; where it takes more, rounding keeps the residual up."""
FORCING_TERM, CAUTIOUS = 0.05, 1e-4
"""Residual of a set over that when it was new at which it is updated: usually, and in a search that is cautious."""
