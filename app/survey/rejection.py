"""What of a survey could not be used, row by row, with the reason."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

LISTED_MOST = 1000
"""Rejections that are listed one by one; the rest are counted only, so that a file of garbage has a short answer."""


@dataclass(frozen=True, slots=True)
class Rejection:
    """One row, fingerprint, reading or file that did not land.

    item : row number of a CSV (the header is row 1), path in a JSON body, or file name and line of a trace.
    """

    item: str | int
    reason: str


@dataclass(slots=True)
class Rejections:
    """The first LISTED_MOST rejections of a survey and the count of all."""

    listed: list[Rejection] = field(default_factory=list)
    count: int = 0

    def add(self, item: str | int, reason: str) -> None:
        """Note one rejection."""
        self.count += 1
        if len(self.listed) < LISTED_MOST:
            self.listed.append(Rejection(item, reason))

    def extend(self, others: Iterable[Rejection], count: int | None = None) -> None:
        """Note several; count : how many they stand for, where only the first are listed."""
        others = tuple(others)
        self.count += len(others) if count is None else count
        self.listed.extend(others[: LISTED_MOST - len(self.listed)])
