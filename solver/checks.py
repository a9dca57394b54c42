"""Checks of user input: every error names the parameter and its value, and says what is allowed."""

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from decimal import Decimal
from numbers import Real
from pathlib import Path
from typing import Any

import numpy as np

from .arrays import Array64

BELOW_ZERO = -math.ulp(0.0)
"""A bound that leaves 0 itself allowed."""


def refusal(name: str, value: object, allowed: str) -> ValueError:
    """The error of a bad value, which it shows on one line, in up to 80 characters."""
    text = " ".join(repr(value).split())
    return ValueError(f"{name} is {text if len(text) <= 80 else f'{text[:76]} ...'}; allowed: {allowed}")


def real(
    name: str, value: object, allowed: str, low: float = -math.inf, high: float = math.inf, *, infinite: bool = False
) -> float:
    """`value` as float if it is a real number with low < value <= high (value < inf unless `infinite`).

    NumPy's scalars are numbers, texts and truth values are none; but where infinity is allowed, 'inf' is, too, which
    stands for it in records. Raises `ValueError`.
    """
    try:
        known = isinstance(value, Real) or (infinite and isinstance(value, str) and value == "inf")
        number = float(value) if known and not isinstance(value, bool) else math.nan  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not low < number <= high or (math.isinf(number) and not infinite):
        raise refusal(name, value, allowed)
    return number


def integer(name: str, value: object, allowed: str, low: int, high: int, multiple: int = 1) -> int:
    """`value` as int if it is a whole number with low <= value <= high and a multiple of `multiple`.

    Like `real` it takes NumPy's scalars, and no texts. Raises `ValueError`.
    """
    given: Any = value if isinstance(value, Real) and not isinstance(value, bool) else math.nan
    try:
        number = int(given)
        good = number == given and low <= number <= high and number % multiple == 0
    except (TypeError, ValueError, OverflowError):
        good = False
    if not good:
        raise refusal(name, value, allowed)
    return number


def array(name: str, value: object, allowed: str, least: int, most: float = math.inf) -> Array64:
    """A copy of `value` in float64 if it is a one-dimensional array of `least` to `most` real numbers: masked values,
    complex numbers, texts and truth values are none. Raises `ValueError`.
    """
    found = None
    with suppress(TypeError, ValueError, OverflowError):
        given = np.asarray(value)
        known = given.dtype.kind in "fiu" or (given.dtype.kind == "O" and all(map(_is_real, given.flat)))
        found = np.array(given, dtype=np.float64) if known and not np.ma.is_masked(value) else None
    if found is None:
        raise refusal(name, value, allowed)
    if found.ndim != 1 or not least <= found.size <= most:
        raise ValueError(f"{name} has shape {found.shape}; allowed: {allowed}")
    return found


def _is_real(value: object) -> bool:
    return isinstance(value, (Real, Decimal)) and not isinstance(value, bool)


def choice(name: str, value: object, allowed: tuple[str, ...]) -> str:
    """`value` if it is one of `allowed`, else `ValueError`."""
    if not isinstance(value, str) or value not in allowed:
        raise refusal(name, value, ", ".join(allowed))
    return value


@contextmanager
def own_code(what: str, allowed: str, part: object = None) -> Iterator[None]:
    """Raise `ValueError` with a name for any error in code of one's own: a layer, an indenter, a variant.

    A `ValueError` that says what is allowed keeps its words. part: whose code it is; an error in a part of the
    program is its bug, and passed on.
    """
    try:
        yield
    except MemoryError:
        raise
    except Exception as error:
        if type(part).__module__.partition(".")[0] == __name__.partition(".")[0]:
            raise
        if isinstance(error, ValueError) and "allowed: " in str(error):
            raise ValueError(str(error)) from error
        raise ValueError(f"{what} fails ({type(error).__name__}: {error}); {allowed}") from error


def available_memory() -> int | None:
    """Free memory of the machine [bytes]; None where the system does not tell (not Linux)."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable")) * 1024
    except (OSError, StopIteration, ValueError):
        return None


def assign(instance: object, **values: object) -> None:
    """Set checked values on a frozen dataclass while it is being made."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


NOT_FINITE = ("inf", "-inf", "nan")
"""Texts for numbers that are not finite, where JSON has no such numbers."""


def plain(value: Any) -> Any:
    """The same value for JSON: tuples as lists, numbers that are not finite as one of `NOT_FINITE`."""
    if isinstance(value, Mapping):
        return {name: plain(item) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, float) and not math.isfinite(value) else value
