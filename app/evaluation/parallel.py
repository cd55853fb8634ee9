"""Independent pieces of work in one process or several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

_Item = TypeVar("_Item")
_Result = TypeVar("_Result")
_work: Callable[[Any], Any] | None = None
"""Of this process, where it is one of several."""


def in_order(work: Callable[[_Item], _Result], items: Sequence[_Item], jobs: int) -> Iterator[_Result]:
    """Results in the order of the items, each as soon as it and those before it are there. One job: no process.

    work : each process receives it once, with whatever it holds (a `partial` with the map of a fold, say), and then
    only the items.
    """
    if jobs == 1:
        yield from map(work, items)
        return
    with ProcessPoolExecutor(jobs, initializer=_keep, initargs=(work,)) as pool:
        yield from pool.map(_done, items)


def _keep(work: Callable[[Any], Any]) -> None:
    global _work
    _work = work


def _done(item: Any) -> Any:
    if _work is None:
        raise RuntimeError("a process of the pool has been given no work")
    return _work(item)
