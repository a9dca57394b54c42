"""The newest event wins: a thread that works on the newest request, and on none that a newer one has replaced."""

import sys
import threading
import traceback
from collections.abc import Callable
from typing import Generic, TypeVar

from ..terminal.text import BUG

Request = TypeVar("Request")


class Newest(Generic[Request]):
    """Does requests one at a time on a thread of its own. Those that wait when a newer one comes are dropped, and one
    that fails is told on standard error.
    """

    told = 5.0
    """Time within which whoever closes a document ends the work for it [s]."""

    def __init__(self, work: Callable[[Request], None]) -> None:
        """work: does a request; where it takes long, it asks `outdated` whether to go on."""
        self._work = work
        self._changed = threading.Condition()
        self._waiting: list[Request] = []  # one at most
        self._ended = False
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def ask(self, request: Request) -> None:
        """Have a request done, in place of one that waits."""
        with self._changed:
            self._waiting = [request]
            self._changed.notify_all()

    def outdated(self, patience: float = 0.0) -> bool:
        """Whether a newer request waits, or the end; looks out for one for so long [s]."""
        with self._changed:
            return self._changed.wait_for(lambda: bool(self._waiting) or self._ended, patience)

    @property
    def ended(self) -> bool:
        """Whether `end` was called."""
        return self._ended

    def end(self, patience: float = 0.0) -> None:
        """Drop the work that waits, and let the thread end after its present work; waits for that for so long [s]."""
        with self._changed:
            self._ended = True
            self._waiting = []
            self._changed.notify_all()
        self._thread.join(patience)

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: bool(self._waiting) or self._ended)
                if self._ended:
                    return
                request = self._waiting.pop()
            try:
                self._work(request)
            except Exception:
                with self._changed:  # a document is gone a little before its page is told to end
                    if self._changed.wait_for(lambda: self._ended, self.told):
                        return
                print(BUG, file=sys.stderr)
                traceback.print_exc()
