"""How scans in use fit radio maps, in the database: sums by square and period, to which every worker adds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from sqlalchemy import delete, func
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import LONG_S, reachable
from app.storage.radio_map_rows import of_version
from app.storage.tables import map_use, radio_maps
from app.storage.upsert import upsert

_ADDED = "scans", "unfit", "visits", "total", "total_square"
_KEYS = "radio_map_id", "floor", "east", "north", "period"


@dataclass(frozen=True, slots=True)
class UsedSquare:
    """Column and row of a square of a floor (app/wifi/survey_likeness.py), and the stretch of time in which it was used
    (app/services/map_use.py)."""

    floor: str
    east: int
    north: int
    period: int


@dataclass(frozen=True, slots=True)
class UseRow:
    """Sums over visits: the stays of sessions in a square.

    unfit : scans that did not fit the track.  total, total_square : of the mean logarithm of the signal distance of
    each visit, and of its square.  session_bits : a bit of 63 for each session.  last_ms : server's clock, Unix.
    """

    scans: int
    unfit: int
    visits: int
    total: float
    total_square: float
    session_bits: int
    last_ms: int

    def plus(self, other: UseRow) -> UseRow:
        """Both together."""
        return UseRow(
            self.scans + other.scans,
            self.unfit + other.unfit,
            self.visits + other.visits,
            self.total + other.total,
            self.total_square + other.total_square,
            self.session_bits | other.session_bits,
            max(self.last_ms, other.last_ms),
        )


class MapUseRows:
    """Reads and writes use; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def add(self, used: Mapping[tuple[str, int], Mapping[UsedSquare, UseRow]]) -> None:
        """Add to what is there. used : by venue and version; what is of versions that are gone is dropped."""
        async with reachable(), self._engine.begin() as connection:
            # of two values max() is SQLite's greatest()
            greatest = func.max if connection.dialect.name == "sqlite" else func.greatest
            adding = upsert(connection, map_use, _KEYS, partial(_changes, greatest=greatest))
            for (venue, version), squares in sorted(used.items()):
                map_id = await connection.scalar(of_version(venue, version, radio_maps.c.id))
                if map_id is None:
                    continue
                # always in the same order: workers that add to the same squares wait for each other in no circle
                for square, row in sorted(squares.items(), key=lambda pair: _order(pair[0])):
                    await connection.execute(adding, _values(map_id, square, row))

    async def read(self, venue: str, version: int, since: int) -> dict[UsedSquare, UseRow]:
        """What is known of a version from a period on; nothing also where there is no such version."""
        columns = (map_use.c[name] for name in (*_KEYS[1:], *_ADDED, "session_bits", "last_ms"))
        query = of_version(venue, version, *columns).join(map_use, map_use.c.radio_map_id == radio_maps.c.id)
        query = query.where(map_use.c.period >= since)
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(query)).all()
        return {UsedSquare(*row[:4]): UseRow(*row[4:]) for row in rows}

    async def forget(self, before: int) -> None:
        """Drop the periods before one."""
        async with reachable(LONG_S), self._engine.begin() as connection:
            await connection.execute(delete(map_use).where(map_use.c.period < before))


def _order(square: UsedSquare) -> tuple[str, int, int, int]:
    return square.floor, square.east, square.north, square.period


def _values(map_id: int, square: UsedSquare, row: UseRow) -> dict[str, Any]:
    values: dict[str, Any] = {"radio_map_id": map_id}
    values |= {name: getattr(square, name) for name in _KEYS[1:]}
    return values | {name: getattr(row, name) for name in (*_ADDED, "session_bits", "last_ms")}


def _changes(excluded: Any, greatest: Any) -> dict[str, Any]:
    added = {name: map_use.c[name] + excluded[name] for name in _ADDED}
    bits = map_use.c.session_bits.bitwise_or(excluded.session_bits)
    return {**added, "session_bits": bits, "last_ms": greatest(map_use.c.last_ms, excluded.last_ms)}
