"""Where tasks run: in this process, in processes of this machine, or on a Dask cluster."""

import atexit
import contextlib
import gc
import multiprocessing
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from dataclasses import dataclass
from typing import Any

from linecontact.solver import checks
from linecontact.solver.methods import Progress

from ..one_thread import ONE_THREAD
from ..terminal import console

_LEAST_MEMORY = 0.5  # GiB: the interpreter with everything loaded takes half of that

_WORKER_ENVIRONMENT = ONE_THREAD | {
    # glibc: keep freed memory; returning it and zeroing it anew takes a sixth of a solve at 2^18
    "MALLOC_TRIM_THRESHOLD_": "1000000000",
    "MALLOC_MMAP_THRESHOLD_": "1000000000",
}


def usable_cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class LostError(ValueError):
    """An executor that is gone for good, like a Dask scheduler that has ended."""


@dataclass(frozen=True)
class Pool:
    """Where tasks run."""

    make: Callable[[], Executor]
    """Makes a new executor."""
    limit: Callable[[], int]
    """Tells how many tasks it should have at a time."""
    budget: int | None = None
    """Memory for each task [bytes]; None: not known."""


@contextlib.contextmanager
def choose(
    workers: int, memory: float | None = None, scheduler: str | None = None, report: Progress | None = None
) -> Iterator[Pool]:
    """Processes on this machine, or with `workers` = 1 this process, or the Dask cluster of a `scheduler`.

    memory: budget of each process [GiB]; by default the free memory, shared. report: shows a solve in this process.
    Raises `ValueError`, and `LostError` when the scheduler goes away.
    """
    check(workers, memory, scheduler)
    if scheduler is not None:
        with _dask(scheduler) as pool:
            yield pool
    elif workers == 1:
        yield Pool(lambda: InProcess(report), lambda: 1, checks.available_memory())
    else:
        free = checks.available_memory()
        gibibytes = memory or (max(1.0, free / 2**30 / workers) if free else None)
        budget = int(gibibytes * 2**30) if gibibytes else None
        # one more waiting for each, so that nobody idles
        yield Pool(lambda: Processes(workers, budget), lambda: 2 * workers, budget)


def check(workers: int, memory: float | None, scheduler: str | None) -> None:
    """Raise `ValueError` for choices that `choose` cannot use."""
    checks.integer("workers", workers, "an integer from 1 to 1024", 1, 1024)
    if memory is not None:
        checks.real("memory", memory, f"a finite number of GiB > {_LEAST_MEMORY}", _LEAST_MEMORY)
        if workers == 1 or scheduler is not None:
            raise ValueError(f"memory is {memory}; allowed: none, it is for worker processes on this machine")
    # of others Dask's client makes a traceback
    if scheduler is not None and not re.fullmatch(r"(tcp|tls|ws|wss|ucx)://\S+:\d+", scheduler):
        raise ValueError(f"scheduler is {scheduler!r}; allowed: an address, like tcp://host:8786")


class InProcess(Executor):
    """Does each task at once, in this process, and shows how its solve is getting on. Ctrl-C passes through."""

    def __init__(self, report: Progress | None) -> None:
        self._report = report

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Call `fn` now; the future is finished when this returns."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, report=self._report, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


class _Worker(multiprocessing.context.SpawnProcess):
    def terminate(self) -> None:
        """Kill the worker: the executor calls this when another has died. SIGTERM, which it would send, is blocked."""
        self.kill()


class _Context(multiprocessing.context.SpawnContext):
    Process = _Worker


class _Workers(dict[int, Any]):
    """Processes by their numbers. In Python 3.11 one thread looks through them while another adds one."""

    def values(self) -> Any:
        return list(super().values())


class Processes(ProcessPoolExecutor):
    """Processes of one thread each, that end with this one and fail beyond their budget of memory [bytes]."""

    def __init__(self, workers: int, budget: int | None) -> None:
        super().__init__(workers, _Context(), _start_worker, (budget,))
        self._processes = _Workers()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """As for any executor; this is where processes are started."""
        with _worker_settings():
            return super().submit(fn, *args, **kwargs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """As for any executor. In Python 3.11 a worker that was being started when another died must be ended here."""
        if self._broken:
            self.abandon()
        super().shutdown(wait, cancel_futures=cancel_futures)

    def abandon(self) -> None:
        """End the processes at once."""
        for process in (self._processes or {}).values():
            process.kill()


def abandon(executor: Executor, futures: Iterable[Future[Any]]) -> None:
    """Give up the tasks that wait, and where that is possible those that are running.

    Leaving the executor still waits for its processes, which takes no time: a thread that is left behind can fail with
    a traceback at the interpreter's end.
    """
    if isinstance(executor, Processes):
        executor.abandon()  # which ends the futures; one that was cancelled besides makes its thread stumble
    else:
        for future in futures:
            future.cancel()
        executor.shutdown(wait=False)


def _start_worker(budget: int | None) -> None:
    """Make this worker end with its parent, however that ends, and keep to its budget of memory [bytes]."""

    def watch() -> None:
        parent = multiprocessing.parent_process()
        if parent:
            parent.join()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
    atexit.register(gc.freeze)  # at its end nothing need be looked for
    if budget:
        with contextlib.suppress(ImportError, ValueError, OSError):  # not POSIX, or a tighter limit already
            import resource

            resource.setrlimit(resource.RLIMIT_DATA, (budget, resource.getrlimit(resource.RLIMIT_DATA)[1]))


@contextlib.contextmanager
def _worker_settings() -> Iterator[None]:
    """Set what workers inherit while they are started: one BLAS thread each, and Ctrl-C and SIGTERM blocked.

    In this process both signals wait until then.
    """
    before = {name: os.environ.get(name) for name in _WORKER_ENVIRONMENT}
    os.environ.update(_WORKER_ENVIRONMENT)
    posix = hasattr(signal, "pthread_sigmask")
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM}) if posix else set()
    try:
        yield
    finally:
        if posix:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        for name, value in before.items():
            os.environ.pop(name)
            if value is not None:
                os.environ[name] = value


@contextlib.contextmanager
def _dask(address: str) -> Iterator[Pool]:
    try:
        from distributed import Client
    except ImportError:
        raise ValueError(
            f"scheduler is {address}; allowed: none, or a Dask scheduler's, with `pip install distributed`"
        ) from None
    try:
        client: Any = Client(address, timeout=10, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ValueError(
            f"scheduler is {address}, where none answers ({error}); allowed: the address that `dask scheduler` prints"
        ) from None
    asked, limit, warned = -1.0, 2, False

    def present() -> int:
        nonlocal asked, limit, warned
        if time.monotonic() - asked > 1:  # workers come and go
            try:
                threads = sum(client.nthreads().values())
            except Exception as error:
                raise LostError(f"scheduler {address} is gone ({error}); run again to continue") from error
            if not threads and not warned:
                warned = True
                console.errors.print(f"scheduler {address} has no workers; waiting")
            asked, limit = time.monotonic(), max(2, 2 * threads)
        return limit

    with contextlib.closing(client):
        yield Pool(lambda: client.get_executor(pure=False), present)
