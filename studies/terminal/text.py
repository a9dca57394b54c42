"""Text for a terminal, whatever it holds. Imports nothing that takes time: a mistyped option is refused at once."""

import math
import sys

NOT_TOO_LARGE = f"a number between -{sys.float_info.max:.1e} and {sys.float_info.max:.1e}"
"""What is allowed where `number` raises `OverflowError`."""


def number(words: str) -> float:
    """The number that words stand for, infinite only where they say inf or infinity.

    Raises `ValueError` for words that are no number, and `OverflowError` for one that is too large.
    """
    found = float(words)
    if math.isinf(found) and "inf" not in words.lower():
        raise OverflowError(words)
    return found


def printable(text: str) -> str:
    """The same without control characters and halves of characters: names and files may hold any."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def complain(message: object) -> None:
    """Write one line on standard error that says what is wrong."""
    print(f"linecontact: {printable(' '.join(str(message).split()))}", file=sys.stderr)
