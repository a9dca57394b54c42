"""The entry point of the command line: Ctrl-C while Python imports everything else is no traceback either.

A scheduler's SIGTERM is taken like Ctrl-C: what there is gets saved. Linear algebra has one thread, unless the user's
environment says otherwise: its matrices are small, and on busy cores its threads wait for each other.
"""

import os
import signal
import sys
from typing import Any, NoReturn


def main() -> int:
    """Run `linecontact`; returns the exit status."""
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):  # read when NumPy is loaded
        os.environ.setdefault(name, "1")
    interrupt, term = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    if interrupt is signal.default_int_handler:  # else someone wants it ignored
        signal.signal(signal.SIGINT, _leave)
    if term is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _leave)
    try:
        from .command_line.main import prepare

        try:
            run = prepare()
        except SystemExit:  # --help has been shown
            sys.stdout.flush()
            return 0
        if term is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, _as_ctrl_c)
        if interrupt is signal.default_int_handler:
            signal.signal(signal.SIGINT, interrupt)
        return run()
    except KeyboardInterrupt:  # outside of any command
        _leave()
    except OSError as error:  # of --help: its reader has gone away, or the disk is full
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # the flush at exit must not fail again
        if isinstance(error, BrokenPipeError):
            return 141
        os.write(2, f"linecontact: {error}\n".encode())
        return 2


def _leave(*_: Any) -> NoReturn:
    os.write(2, b"linecontact: interrupted\n")
    os._exit(130)


def _as_ctrl_c(*_: Any) -> None:
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in a script's background
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGINT)


if __name__ == "__main__":
    sys.exit(main())
