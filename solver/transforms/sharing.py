"""Work on parts that do not touch each other, shared between threads."""

import threading
from collections.abc import Callable, Sequence
from typing import TypeVar

from ...kernels import undivided

Worker = TypeVar("Worker")
Part = TypeVar("Part")


def do_all(workers: Sequence[Worker], parts: Sequence[Part], work: Callable[[Worker, Part], None]) -> None:
    """Do `work` on every part, each worker in a thread of its own, the first one in this thread.

    Python's lock is held for a small share of the time only: NumPy, FFTW and Warp give it back while they work. Returns
    when all workers have ended, and then raises what went wrong first; Ctrl-C waits for that, too.
    """
    failed: list[BaseException] = []

    def in_turn(number: int) -> None:
        try:
            for part in parts[number :: len(workers)]:
                work(workers[number], part)
        except BaseException as error:
            failed.append(error)

    here, threads = [0], []
    with undivided():
        for number in range(1, len(workers)):
            thread = threading.Thread(target=in_turn, args=(number,))
            try:
                thread.start()
                threads.append(thread)
            except RuntimeError:  # no more threads, or the interpreter is about to end
                here.append(number)
        for number in here:
            in_turn(number)
        for thread in threads:
            thread.join()
    if failed:
        raise failed[0]
