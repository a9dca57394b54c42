"""Text for a terminal, whatever it holds. Imports nothing that takes time: a mistyped option is refused at once."""

import math
import sys

IN_RANGE = f"a number of {math.ulp(0.0):.1e} to {sys.float_info.max:.1e} in size"
"""What is allowed where `number` raises `OverflowError`."""


def number(words: str) -> float:
    """The number that words stand for, which may be a power, like 2^18; -2^18 is its negative.

    It is infinite only where they say inf or infinity, and 0 where all digits are. Raises `ValueError` for words that
    are no number, and `OverflowError` for one that is too large or too small.
    """
    base, _, exponent = words.partition("^")
    if exponent:
        return _power(number(base), int(exponent))
    found = float(words)
    digits = words.lower().partition("e")[0].strip()
    if (math.isinf(found) and "inf" not in words.lower()) or (found == 0 and set(digits) - set("+-0._")):
        raise OverflowError(words)
    return found


def _power(base: float, exponent: int) -> float:
    if base == 0 and exponent < 0:
        raise OverflowError(f"0^{exponent}")
    found = math.copysign(abs(base) ** exponent, base)
    if found == 0 and base != 0:
        raise OverflowError(f"{base}^{exponent}")
    return found


def pointed(words: str, unit: str = "") -> str:
    """What is allowed in the place of a number with a decimal comma; empty for all other words.

    unit: what stands behind it.
    """
    better = words.replace(",", ".")
    try:
        number(better)
    except (ValueError, OverflowError):
        return ""
    return f"a number with a decimal point, like {better}{unit}" if better != words else ""


def printable(text: str) -> str:
    """The same without control characters and halves of characters: names and files may hold any."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def complain(message: object) -> None:
    """Write one line on standard error that says what is wrong."""
    print(f"linecontact: {printable(' '.join(str(message).split()))}", file=sys.stderr)
