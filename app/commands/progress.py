"""The progress bar of the commands that measure: on standard error, so that standard output is theirs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import MofNCompleteColumn, Progress, TimeRemainingColumn

_CONSOLE = Console(stderr=True)


@contextmanager
def counting(description: str, total: int) -> Iterator[Callable[[], None]]:
    """A bar that counts to total while the block runs; gives what is to be called after each piece of work."""
    columns = (*Progress.get_default_columns()[:2], MofNCompleteColumn(), TimeRemainingColumn())
    # without a thread that refreshes it: workers are forked off this process
    with Progress(*columns, console=_CONSOLE, auto_refresh=False) as bar:
        task = bar.add_task(description, total=total)
        bar.refresh()
        yield lambda: bar.update(task, advance=1, refresh=True)
        bar.update(task, total=bar.tasks[task].completed)  # some of the work may have turned out to be none
