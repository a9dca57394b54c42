"""Work on parts that do not touch each other, shared between threads."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import TypeVar

Worker = TypeVar("Worker")
Part = TypeVar("Part")


def share(workers: Sequence[Worker], parts: Sequence[Part], work: Callable[[Worker, Part], None]) -> None:
    """Do `work` on every part, each worker in a thread of its own, the first one in this thread.

    Python's lock is held for a small share of the time only: NumPy, FFTW and Warp give it back while they work. Returns
    when all workers have ended, after Ctrl-C, too; raises what went wrong first.
    """

    def in_turn(number: int) -> None:
        for part in parts[number :: len(workers)]:
            work(workers[number], part)

    if len(workers) == 1:
        in_turn(0)
        return
    with ThreadPoolExecutor(len(workers) - 1) as pool:
        others = [pool.submit(in_turn, number) for number in range(1, len(workers))]
        in_turn(0)
    for other in others:
        other.result()
