"""The entry point of the command line: Ctrl-C while Python imports everything else is no traceback either.

A scheduler's SIGTERM is taken like Ctrl-C: results so far are saved. Linear algebra has one thread, unless the user's
environment says otherwise: its matrices are small, and on busy cores its threads wait for each other.

Python does not look for garbage while everything is imported, nor at its end: imports make many objects and leave next
to none, and a quarter of the time of a short command would go by in looking.
"""

import gc
import os
import signal
import sys
from typing import Any, NoReturn

from .one_thread import ONE_THREAD
from .terminal.text import open_streams


def main() -> int:
    """Run `linecontact`; returns the exit status."""
    open_streams()
    for name, count in ONE_THREAD.items():
        os.environ.setdefault(name, count)
    interrupt, term = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    if interrupt is signal.default_int_handler:  # else someone wants it ignored
        signal.signal(signal.SIGINT, _leave)
    if term is signal.SIG_DFL:
        signal.signal(signal.SIGTERM, _leave)
    gc.disable()
    try:
        from .command_line.main import prepare

        try:
            run = prepare()
        except SystemExit:  # --help has been shown
            run = lambda: 0  # noqa: E731
        finally:
            gc.freeze()
            gc.enable()
        if term is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, _as_ctrl_c)
        if interrupt is signal.default_int_handler:
            signal.signal(signal.SIGINT, interrupt)
        status = run()
        sys.stdout.flush()
        return status
    except KeyboardInterrupt:  # outside of any command
        _leave()
    except Exception as error:  # outside, too: the reader of --help has gone away, or the disk is full
        return _ended_by(error)
    finally:
        if interrupt is signal.default_int_handler:  # threads and files are closed after this
            signal.signal(signal.SIGINT, _leave)
        gc.freeze()


def _ended_by(error: Exception) -> int:
    """The exit status, as that of any command which ends like this."""
    from .terminal import console

    def fail() -> int:
        raise error

    return console.guard(fail)


def _leave(*_: Any) -> NoReturn:
    os.write(2, b"linecontact: interrupted\n")
    os._exit(130)


def _as_ctrl_c(*_: Any) -> None:
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in a script's background
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGINT)


if __name__ == "__main__":
    sys.exit(main())
