"""Text for a terminal, whatever it holds. Imports nothing that takes time: a mistyped option is refused at once."""

import io
import math
import os
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


BUG = "linecontact: a bug, please report it with this traceback"


def is_refusal(error: BaseException) -> bool:
    """Whether a `raise` of ours has raised a `ValueError`, which says what is wrong with the input.

    One that Python or a library has raised, like that of the logarithm of 0, is a bug of ours.
    """
    import dis

    place = error.__traceback__
    while place and place.tb_next:
        place = place.tb_next
    if place is None or not isinstance(error, ValueError):
        return False
    ours = place.tb_frame.f_globals.get("__name__", "").partition(".")[0] == __name__.partition(".")[0]
    return ours and dis.opname[place.tb_frame.f_code.co_code[place.tb_lasti]] == "RAISE_VARARGS"


def open_streams() -> None:
    """Give the process the standard streams that it was started without, which lead nowhere, and let the others take
    any character: what the terminal cannot show is spelled out.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:  # the first free number is given next, and children must not be without it either
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    sys.stdout = sys.stdout or os.fdopen(1, "w", closefd=False)
    sys.stderr = sys.stderr or os.fdopen(2, "w", closefd=False)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
