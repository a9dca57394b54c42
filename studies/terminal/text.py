"""Text for a terminal, whatever it holds. Imports nothing that takes time: a mistyped option is refused at once."""

import sys


def printable(text: str) -> str:
    """The same without control characters and halves of characters: names and files may hold any."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else repr(c)[1:-1] for c in text)


def complain(message: object) -> None:
    """Write one line on standard error that says what is wrong."""
    print(f"linecontact: {printable(' '.join(str(message).split()))}", file=sys.stderr)
