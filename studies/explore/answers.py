"""The answer to a scene: its solution, or the reason why there is none, and the time that it took."""

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from linecontact.solver import Scene, Solution, Status, solve

from ..terminal.text import is_refusal

_ONE_AT_A_TIME = threading.Lock()
"""Pages share the solver's plans and workspaces."""


class DroppedError(Exception):
    """Nobody waits for the answer any more."""


@dataclass(frozen=True)
class Answer:
    """The answer for a scene."""

    scene: Scene | None
    """The scene; None where the numbers make none."""
    solution: Solution | None
    """Its solution if that converged."""
    refused: str
    """Why there is no solution; empty if there is one."""
    seconds: float
    """Wall time of the solve [s]."""


def answer(make: Callable[[], Scene], dropped: Callable[[], bool]) -> Answer:
    """Make a scene and solve it. Errors are told in the answer.

    dropped: whether to stop, asked about ten times a second; then `DroppedError` is raised.
    """

    def check(*_: object) -> None:
        if dropped():
            raise DroppedError

    scene, began = None, time.perf_counter()
    try:
        scene = make()
        with _ONE_AT_A_TIME:
            check()
            began = time.perf_counter()
            solution = solve(scene, progress=check)
    except DroppedError:
        raise
    except Exception as error:  # also of an indenter or a layer of one's own: the page must say so and go on
        why = f"Refused: {error}" if is_refusal(error) else f"Failed: {type(error).__name__}: {error}"
        return Answer(scene, None, why, time.perf_counter() - began)
    seconds = time.perf_counter() - began
    if solution.status is not Status.CONVERGED:
        return Answer(scene, None, f"Not converged ({solution.status}): {solution.reason}", seconds)
    return Answer(scene, solution, "", seconds)
