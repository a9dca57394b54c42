"""pyFFTW without SciPy and Dask, which it would import for its interfaces to them, and which take most of a second.

Nothing here uses those interfaces. SciPy and Dask can be imported before or after this as ever.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def _without(*names: str) -> Iterator[None]:
    """Importing one of these packages fails for a while, unless it is loaded already."""
    hidden = [name for name in names if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]  # None is Python's mark for "not to be had"
    try:
        yield
    finally:
        for name in hidden:
            if sys.modules.get(name) is None:
                sys.modules.pop(name, None)


with _without("scipy", "dask"):
    import pyfftw

__all__ = ["pyfftw"]
