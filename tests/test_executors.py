"""Processes of this machine: what they are told, how they end, and that none is left behind."""

import os
import signal
import threading
import time
from concurrent.futures import BrokenExecutor
from types import SimpleNamespace

import pytest
from linecontact.studies.runner import executors

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")

PATIENCE = 120  # seconds for what takes a second or two on an idle machine


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"workers": 1025}, "workers is 1025"),
        ({"memory": 0.0}, r"memory is 0\.0"),
        ({"memory": float("nan")}, "memory is nan"),
        ({"memory": 1.0, "workers": 1}, r"memory is 1\.0"),
        ({"memory": 1.0, "scheduler": "tcp://127.0.0.1:1"}, r"memory is 1\.0"),
    ],
)
def test_bad_options_are_named(options, message):
    with pytest.raises(ValueError, match=message), executors.choose(**{"workers": 2, **options}):
        pass


def test_abandoned_processes_leave_quietly(monkeypatch):
    """A cancelled future made the executor's thread stumble, with a traceback, when its processes ended; a thread that
    was still there at the interpreter's end made that stumble.
    """
    stumbled = []
    monkeypatch.setattr(threading, "excepthook", stumbled.append)
    for pause in (0.0, 0.3, 1.5):  # while processes are started, and after
        with executors.Processes(1, None) as executor:
            futures = [executor.submit(time.sleep, 60) for _ in range(3)]
            thread = executor._executor_manager_thread
            time.sleep(pause)
            executors.abandon(executor, futures)
        assert not thread.is_alive()
    assert not stumbled


def test_a_scheduler_s_signal_is_not_the_workers_business():
    """From their first instant on: while they imported, it made them die and their tasks be tried again."""
    with executors.Processes(1, None) as executor:
        future = executor.submit(abs, -2)
        (worker,) = executor._processes
        for _ in range(20):
            os.kill(worker, signal.SIGTERM)
            time.sleep(0.02)
        assert future.result(PATIENCE) == 2


def test_a_worker_s_death_does_not_wait_for_the_others():
    with executors.Processes(2, None) as executor:
        futures = [executor.submit(time.sleep, 20), executor.submit(signal.raise_signal, signal.SIGKILL)]
        futures.append(executor.submit(time.sleep, 20))  # the executor looks after a worker from the next task on
        workers = list(executor._processes.values())
        for broken in futures:
            with pytest.raises(BrokenExecutor):
                broken.result(PATIENCE)
    assert [worker.exitcode for worker in workers] == 2 * [-signal.SIGKILL]


def test_a_worker_that_starts_when_another_dies_is_not_left_behind(monkeypatch):
    """Python 3.11 overlooked it, or waited for it for ever."""
    start, workers = executors._Worker.start, []

    def slow_start(self):
        start(self)
        workers.append(self)
        if len(workers) == 2:
            workers[0].kill()
            workers[0].join(PATIENCE)
            time.sleep(1)  # for the executor to notice

    monkeypatch.setattr(executors._Worker, "start", slow_start)
    with executors.Processes(2, None) as executor:
        futures = [executor.submit(time.sleep, PATIENCE) for _ in range(2)]
        for broken in futures:
            with pytest.raises(BrokenExecutor):
                broken.result(PATIENCE)
    for worker in workers:
        worker.join(PATIENCE)
    assert [worker.exitcode for worker in workers] == 2 * [-signal.SIGKILL]


def test_workers_are_looked_through_while_one_is_added():
    with executors.Processes(2, None) as executor:
        executor.submit(abs, 1)
        workers = iter(executor._processes.values())
        executor._processes[-1] = SimpleNamespace()
        assert len(list(workers)) == 1
        del executor._processes[-1]
