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
    signal.signal(signal.SIGTERM, _as_ctrl_c)
    try:
        from .cli import main as run

        signal.signal(signal.SIGINT, before)
        return run()
    except KeyboardInterrupt:  # outside of any command
        _leave()
        raise


def _as_ctrl_c(*_: Any) -> None:
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in a script's background
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGINT)


def _leave(*_: Any) -> None:
    os.write(2, b"linecontact: interrupted\n")
    os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
