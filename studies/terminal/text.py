"""Text for a terminal, whatever it holds. Imports nothing that takes time: a mistyped option is refused at once."""

import io
import math
import os
import sys
from pathlib import Path
from typing import Any, TextIO

IN_RANGE = f"a number of {math.ulp(0.0):.1e} to {sys.float_info.max:.1e} in size"
"""The allowed values where `number` raises `OverflowError`."""


def shown_name(path: Path) -> str:
    """The file's name for records: they are UTF-8, which not all names are."""
    return os.fsencode(path.name).decode("utf-8", "backslashreplace")


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
    """The allowed words in place of a number with a decimal comma; empty for all other words.

    unit: of the number.
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
    """Write one line on standard error that names the error."""
    print(f"linecontact: {printable(' '.join(str(message).split()))}", file=sys.stderr)


OUTPUT = "standard output"
BUG = "linecontact: a bug, please report it with this traceback"


def is_refusal(error: BaseException) -> bool:
    """Whether a `raise` of ours has raised a `ValueError`, which is about the input.

    One that Python or a library has raised, like that of the logarithm of 0, is a bug of ours.
    """
    import dis

    place = error.__traceback__
    while place and place.tb_next:
        place = place.tb_next
    if place is None or not isinstance(error, ValueError):
        return False
    ours = str(place.tb_frame.f_globals.get("__package__")).partition(".")[0] == __name__.partition(".")[0]
    return ours and dis.opname[place.tb_frame.f_code.co_code[place.tb_lasti]] == "RAISE_VARARGS"


class _Standard(io.FileIO):
    """A standard stream that is written to; errors there have the stream for their file."""

    def write(self, data: Any, /) -> int:
        """As of any file."""
        try:
            return super().write(data)
        except OSError as error:
            error.filename = OUTPUT if self.fileno() == 1 else "standard error"
            raise


def open_streams() -> None:
    """Open the standard streams as the program needs them: those that it was started without lead nowhere, and what the
    terminal's encoding does not have is spelled out.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:  # the first free number is given next, and children must not be without it either
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)
    sys.stdout, sys.stderr = (_open(number, now) for number, now in ((1, sys.stdout), (2, sys.stderr)))


def _open(number: int, now: TextIO | None) -> TextIO:
    raw = _Standard(number, "w", closefd=False)
    lines = number == 2 or raw.isatty()
    known = now.encoding if now else "utf-8"
    return io.TextIOWrapper(io.BufferedWriter(raw), known, "backslashreplace", line_buffering=lines)
