"""Who solves the cells: processes on this machine, each alone, or the workers of a Dask cluster.

CasADi, IPOPT and FLINT are neither safe in threads nor can their objects be sent, so a worker is a fresh process that
builds everything itself.
"""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context
from multiprocessing.connection import Connection
from types import ModuleType
from typing import Any, ParamSpec, TypeVar

from ..errors import InputError, RobimpError

P = ParamSpec("P")
T = TypeVar("T")

ANSWER = 5  # s a scheduler has to answer
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


class Processes(Executor):
    """An executor of processes of which one may die: its own task fails, with BrokenProcessPool, and no other.

    Each process has a pool of its own. All of them end with this one, even when it is killed: see `_prepare`.
    """

    def __init__(self, count: int) -> None:
        self.size = count
        self._context = get_context("spawn")
        self._read_end, self._lifeline = self._context.Pipe(duplex=False)
        self._idle: list[ProcessPoolExecutor] = []
        self._busy: dict[Future[Any], ProcessPoolExecutor] = {}

    def submit(self, fn: Callable[P, T], /, *args: P.args, **kwargs: P.kwargs) -> Future[T]:
        """Give a task to an idle process, at most `size` at once."""
        for done in [future for future in self._busy if future.done()]:
            pool = self._busy.pop(done)
            if isinstance(done.exception(), BrokenProcessPool):
                pool.shutdown(wait=False)
            else:
                self._idle.append(pool)
        if len(self._busy) >= self.size:
            raise RobimpError("more tasks than processes")
        pool = self._idle.pop() if self._idle else self._pool()
        with _one_thread_each(), _caller_hidden():  # the process is started here
            future = pool.submit(fn, *args, **kwargs)
        self._busy[future] = pool
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End every process, also in the middle of a task."""
        self._lifeline.close()
        for pool in [*self._idle, *self._busy.values()]:
            pool.shutdown(wait=wait, cancel_futures=True)
        self._read_end.close()

    def _pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(1, mp_context=self._context, initializer=_prepare, initargs=(self._read_end,))


def _prepare(lifeline: Connection) -> None:
    """In a new process: leave Ctrl-C to the parent, and end when the other end of the lifeline closes or dies."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def watch() -> None:
        try:
            lifeline.recv()
        except EOFError:
            os._exit(0)

    threading.Thread(target=watch, daemon=True).start()


@contextmanager
def _caller_hidden() -> Iterator[None]:
    """A spawned process imports the caller's script again, which would begin the map again: it has no need to."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """NumPy's library looks at the environment when it is loaded."""
    before = {name: os.environ.get(name) for name in ONE_THREAD}
    os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


@contextmanager
def workers(processes: int | None, dask: str | None) -> Iterator[tuple[Executor, int]]:
    """An executor, and how many tasks it works on at once. Raises: InputError for a cluster that cannot be used."""
    if dask is not None:
        with _cluster(dask) as both:
            yield both
        return
    crew = Processes(processes or os.cpu_count() or 1)
    try:
        yield crew, crew.size
    finally:
        crew.shutdown()


@contextmanager
def _cluster(address: str) -> Iterator[tuple[Executor, int]]:
    try:
        from distributed import Client
    except ImportError:
        raise InputError("--dask needs the package dask.distributed: install robimp[dask]") from None
    try:
        client = Client(address, timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise InputError(f"--dask: no scheduler answers at {address}: {error}") from None
    try:
        threads = client.nthreads()
        if not threads:
            raise InputError(f"--dask: the cluster at {address} has no workers")
        crowded = next((f"{worker} has {n}" for worker, n in threads.items() if n != 1), None)
        if crowded is not None:
            raise InputError(
                f"--dask: the solvers are not safe in threads, and {crowded} of them; start workers with --nthreads 1"
            )
        yield client.get_executor(pure=False), len(threads)
    finally:
        client.close()
