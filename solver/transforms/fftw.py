"""pyFFTW without SciPy and Dask, which its interfaces would import although nothing here uses them; and its planner.

They are hidden only while pyFFTW is being imported; afterwards they can be imported as ever. pyFFTW's interfaces for
them are then missing: who wants those imports pyFFTW first.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from ...kernels.locks import PLANNING


@contextmanager
def _hidden(*names: str) -> Iterator[None]:
    """Modules that are not loaded yet cannot be imported meanwhile."""
    hidden = [name for name in names if name not in sys.modules]
    for name in hidden:
        sys.modules[name] = None  # type: ignore[assignment]
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]


with _hidden("scipy", "dask"):
    import pyfftw

__all__ = ["plan", "pyfftw"]


def plan(*arrays: Any, **options: Any) -> Any:
    """`pyfftw.FFTW`: a child of a fork would wait for ever for a planner at work elsewhere."""
    with PLANNING:
        return pyfftw.FFTW(*arrays, **options)
