"""Checks of user input: every error names the parameter, its value and what is allowed."""

import math
from pathlib import Path


def real(
    name: str, value: object, allowed: str, low: float = -math.inf, high: float = math.inf, *, infinite: bool = False
) -> float:
    """`value` as float if low < value <= high (value < inf unless `infinite`), else `ValueError`."""
    try:
        number = float(value) if not isinstance(value, bool) else math.nan  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not low < number <= high or (math.isinf(number) and not infinite):
        raise ValueError(f"{name} is {value!r}; allowed: {allowed}")
    return number


def integer(name: str, value: object, allowed: str, low: int, high: int, multiple: int = 1) -> int:
    """`value` as int if low <= value <= high and a multiple of `multiple`, else `ValueError`."""
    try:
        number = int(value)  # type: ignore[call-overload]
        good = number == value and not isinstance(value, bool) and low <= number <= high and number % multiple == 0
    except (TypeError, ValueError, OverflowError):
        good = False
    if not good:
        raise ValueError(f"{name} is {value!r}; allowed: {allowed}")
    return int(number)


def choice(name: str, value: object, allowed: tuple[str, ...]) -> str:
    """`value` if it is one of `allowed`, else `ValueError`."""
    if not isinstance(value, str) or value not in allowed:
        raise ValueError(f"{name} is {value!r}; allowed: {', '.join(allowed)}")
    return value


def available_memory() -> int | None:
    """Free memory of the machine [bytes]; None where there is no telling (not Linux)."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("MemAvailable")) * 1024
    except (OSError, StopIteration, ValueError):
        return None


def assign(instance: object, name: str, value: object) -> None:
    """Set a checked value on a frozen dataclass while it is being made."""
    object.__setattr__(instance, name, value)
