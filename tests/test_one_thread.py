"""Linear algebra takes one thread during a solve, and what the user has set is back after it."""

import threading

import numpy as np  # loads the library whose threads are counted
import pytest
from linecontact.solver import PowerIndenter, Scene, contact_stiffness, solve
from linecontact.solver.arrays import _libraries, on_one_thread
from threadpoolctl import threadpool_info, threadpool_limits


def threads():
    return {one["num_threads"] for one in threadpool_info() if one["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def two():
    """The user's own setting."""
    _libraries.cache_clear()  # other tests may have loaded more
    np.linalg.solve(np.eye(2), np.ones(2))
    with threadpool_limits(2, user_api="blas"):
        if threads() != {2}:
            pytest.skip("this NumPy has a BLAS of one thread")
        yield


class Watching(PowerIndenter):
    def profile(self, num_points, period):
        self.seen.append(threads())
        return super().profile(num_points, period)


def test_a_solve_has_one_thread(monkeypatch):
    monkeypatch.setattr(Watching, "seen", [], raising=False)
    solution = solve(Scene(indenter=Watching(), num_points=2**10))
    assert Watching.seen
    assert all(seen == {1} for seen in Watching.seen)
    assert threads() == {2}
    contact_stiffness(solution)
    assert threads() == {2}


def test_after_an_error():
    with pytest.raises(ValueError, match="scene is of type int"):
        solve(3)
    assert threads() == {2}


def test_what_was_set_is_back_after_several_threads():
    """Each of them restoring what it had found left one thread for good."""

    @on_one_thread()
    def wait(inside, leave):
        inside.set()
        assert leave.wait(60)

    started = []
    for _ in range(2):
        inside, leave = threading.Event(), threading.Event()
        thread = threading.Thread(target=wait, args=(inside, leave))
        thread.start()
        assert inside.wait(60)
        started.append((thread, leave))
    for thread, leave in started:  # the first to begin is the first to end
        leave.set()
        thread.join()
    assert threads() == {2}
