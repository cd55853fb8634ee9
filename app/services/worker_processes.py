"""Processes for work that would keep phones waiting: reading surveys, building radio maps.

Threads would not do: such work holds the interpreter, and every batch would wait its turn.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import wait
from typing import ParamSpec, TypeVar

from app.errors import DependencyDown

PROCESSES = 2
"""One may read a large survey for minutes; another takes the short ones meanwhile."""
LARGE_BYTES = 200_000
"""Of JSON: reading it holds the interpreter for some milliseconds."""
_P = ParamSpec("_P")
_R = TypeVar("_R")


class WorkerProcesses:
    """Runs functions in processes of their own, which are started at first use."""

    def __init__(self, processes: int = PROCESSES) -> None:
        self._processes = processes
        self._pool: ProcessPoolExecutor | None = None

    async def run(self, function: Callable[_P, _R], *args: _P.args, **kwargs: _P.kwargs) -> _R:
        """What the function gives or raises; function, arguments and result travel by pickle.

        Raises
        ------
        DependencyDown : the process died.
        """
        if self._pool is None:
            self._pool = ProcessPoolExecutor(
                self._processes, mp_context=multiprocessing.get_context("spawn"), initializer=_belong_to_parent
            )
        pool = self._pool
        try:
            return await asyncio.wrap_future(pool.submit(function, *args, **kwargs))
        except BrokenProcessPool as error:
            if self._pool is pool:
                self._pool = None
            raise DependencyDown("a worker process died before it was done; nothing was stored") from error

    async def run_of(self, size_bytes: int, function: Callable[_P, _R], *args: _P.args, **kwargs: _P.kwargs) -> _R:
        """The same of an input of so many bytes; of a small one beside the event loop, which waits for no large one."""
        if size_bytes < LARGE_BYTES:
            return await asyncio.to_thread(function, *args, **kwargs)
        return await self.run(function, *args, **kwargs)

    async def close(self) -> None:
        """Wait for what runs, and end the processes."""
        await asyncio.to_thread(self.stop)

    def stop(self) -> None:
        """The same, blocking."""
        pool, self._pool = self._pool, None
        if pool is not None:
            pool.shutdown(cancel_futures=True)


def _belong_to_parent() -> None:
    """Leave Ctrl-C to the parent, and die with it even if it was killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None  # this runs in a child only
    threading.Thread(target=_die_with, args=(parent.sentinel,), daemon=True).start()


def _die_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)
