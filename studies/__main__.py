"""The entry point of the command line: Ctrl-C while Python imports everything else is no traceback either.

A scheduler's SIGTERM is taken like Ctrl-C: what there is gets saved.
"""

import os
import signal
import sys
from typing import Any


def main() -> int:
    """Run `linecontact`; returns the exit status."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:  # else someone wants it ignored
        signal.signal(signal.SIGINT, _leave)
        signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    from .cli import main as run

    signal.signal(signal.SIGINT, before)
    return run()


def _leave(*_: Any) -> None:
    os.write(2, b"linecontact: interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
