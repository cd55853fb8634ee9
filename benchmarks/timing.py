"""How long a call takes, and the table of a run."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from rich import box
from rich.console import Console
from rich.table import Table

BUDGET_S = 0.6
"""Spent on each measurement."""


@dataclass(frozen=True, slots=True)
class Row:
    """One measurement. Times in microseconds; at_least : what the ratio reference / ours must reach, None: no bound."""

    what: str
    ours_us: float
    reference: str = ""
    reference_us: float | None = None
    at_least: float | None = None

    @property
    def ratio(self) -> float | None:
        """How many times faster than the reference of the same run."""
        return None if self.reference_us is None else self.reference_us / self.ours_us

    @property
    def holds(self) -> bool:
        """Whether the bound on the ratio is kept."""
        return self.at_least is None or (self.ratio is not None and self.ratio >= self.at_least)


def median_us(*calls: Callable[[], object]) -> list[float]:
    """Median time of each call, taken in turns, so that a machine that slows down slows all of them."""
    for call in calls:
        call()
    loops = [max(1, int(2e-4 / max(_seconds(call, 1), 1e-9))) for call in calls]
    samples: list[list[float]] = [[] for _ in calls]
    gc.disable()
    try:
        until = time.perf_counter() + BUDGET_S * len(calls)
        while time.perf_counter() < until or len(samples[0]) < 5:
            for call, count, taken in zip(calls, loops, samples, strict=True):
                taken.append(_seconds(call, count) / count)
    finally:
        gc.enable()
    return [1e6 * float(np.median(taken)) for taken in samples]


def show(rows: list[Row]) -> None:
    """Print the rows as a table."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in ("what", "time", "reference", "its time", "ratio", "must be"):
        table.add_column(column, justify="left" if column in ("what", "reference") else "right", no_wrap=True)
    for row in rows:
        bound = "" if row.at_least is None else f">= {row.at_least:g} {'' if row.holds else 'MISSED'}"
        ratio = "" if row.ratio is None else f"{row.ratio:.2g}" if row.ratio < 10 else f"{row.ratio:.0f}"
        table.add_row(row.what, _time(row.ours_us), row.reference, _time(row.reference_us), ratio, bound)
    Console(width=None if Console().is_terminal else 130).print(table)


def _seconds(call: Callable[[], object], count: int) -> float:
    began = time.perf_counter()
    for _ in range(count):
        call()
    return time.perf_counter() - began


def _time(microseconds: float | None) -> str:
    if microseconds is None:
        return ""
    return f"{microseconds:.1f} us" if microseconds < 1000.0 else f"{microseconds / 1000.0:.2f} ms"
