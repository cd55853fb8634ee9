from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from app.errors import DependencyDown
from app.fusion.interface import Site
from app.observations import Carrying, Fix, Flag, Integrity, Motion, Position, RadioFix
from app.services.map_drift import sessions_of
from app.services.map_use import IDLE_MS, LONGEST_MS, PERIOD_MS, MapUse
from app.storage.map_use_rows import MapUseRows, UsedSquare, UseRow
from app.wifi.fix_calibration import calibrated_map
from tests.wifi.test_fix_calibration import walks

SITE = Site(radio_map=calibrated_map(walks(20, 3.0), version=2))
NOW_MS = 700 * PERIOD_MS + 1000
SQUARE = UsedSquare("F1", 1, 0, 700)
Use = Callable[[MapUse, "Rows", list[int]], Awaitable[Any]]


@dataclass
class Rows(MapUseRows):
    """A database in memory, which can be down. adding : how often something was written."""

    kept: dict[tuple[str, int], dict[UsedSquare, UseRow]] = field(default_factory=dict)
    down: bool = False
    adding: int = 0

    async def add(self, used: Mapping[tuple[str, int], Mapping[UsedSquare, UseRow]]) -> None:
        if self.down:
            raise DependencyDown("the database cannot be reached")
        self.adding += 1
        for version, squares in used.items():
            for square, row in squares.items():
                had = self.kept.setdefault(version, {}).get(square)
                self.kept[version][square] = row if had is None else had.plus(row)

    async def read(self, venue: str, version: int, since: int) -> dict[UsedSquare, UseRow]:
        return {at: row for at, row in self.kept.get((venue, version), {}).items() if at.period >= since}


def run(use: Use, told: list[tuple[str, int]] | None = None) -> None:
    """Use a counter of use; the list of one number is its clock."""
    rows, clock_ms, heard = Rows(), [NOW_MS], told if told is not None else []
    counter = MapUse(rows, lambda: clock_ms[0], lambda venue, count: heard.append((venue, count)))
    asyncio.run(use(counter, rows, clock_ms))  # type: ignore[arg-type]


def fix(*distance: float, x_m: float = 15.0, fits: bool = True, flag: Flag = Flag.NOMINAL, source: str = "wifi") -> Fix:
    """A Fix on F1 that rests on WiFi scans of these signal distances."""
    scans = [RadioFix(0.0, "F1", np.zeros(2), np.eye(2), 1.0, one, fits, source) for one in distance]
    integrity = Integrity(flag, True, 0, 0, 0, None, None, 9.0, 10.0, 0.01)
    position = Position(x_m, 1.0, "F1")
    unknown = (None, None, None, None)
    return Fix(0.0, position, *unknown, 0, Motion.WALKING, Carrying.UNKNOWN, integrity, (), tuple(scans))


def test_the_scans_of_a_session_in_a_square_are_one_visit() -> None:
    async def use(counter: MapUse, rows: Rows, clock_ms: list[int]) -> None:
        await counter.heard("mall", SITE, "a", "surefix", fix(np.exp(-1.0), np.exp(-3.0)))
        await counter.heard("mall", SITE, "a", "surefix", fix(np.exp(-5.0), fits=False))
        await counter.heard("mall", SITE, "a", "surefix", fix(0.1, x_m=25.0))
        assert rows.kept == {}
        await counter.close()
        row = rows.kept["mall", 2][SQUARE]
        assert (row.scans, row.unfit, row.visits, row.last_ms) == (3, 1, 1, NOW_MS)
        assert (row.total, row.total_square) == pytest.approx((-3.0, 9.0))
        assert rows.kept["mall", 2][replace(SQUARE, east=2)].scans == 1

    run(use)


def test_sessions_are_counted_apart_and_their_number_is_told_from_their_bits() -> None:
    async def use(counter: MapUse, rows: Rows, clock_ms: list[int]) -> None:
        for number in range(40):
            for _ in range(2):
                await counter.heard("mall", SITE, f"session {number}", "surefix", fix(0.1))
        await counter.close()
        row = rows.kept["mall", 2][SQUARE]
        assert (row.visits, row.scans) == (40, 80)
        assert sessions_of(row.session_bits) == pytest.approx(40.0, rel=0.25)
        assert sessions_of(0) == 0.0

    run(use)


def test_a_visit_ends_when_nothing_comes_any_more_and_a_phone_that_stays_is_counted_again() -> None:
    async def use(counter: MapUse, rows: Rows, clock_ms: list[int]) -> None:
        await counter.heard("mall", SITE, "a", "surefix", fix(0.1))
        clock_ms[0] += IDLE_MS - 1
        await counter.heard("mall", SITE, "b", "surefix", fix(0.1))
        counter.end_idle()
        await counter.flush()
        assert rows.kept == {}
        clock_ms[0] += 1
        counter.end_idle()
        await counter.flush()
        assert rows.kept["mall", 2][SQUARE].visits == 1
        clock_ms[0] += LONGEST_MS
        await counter.heard("mall", SITE, "b", "surefix", fix(0.1))
        await counter.close()
        row = rows.kept["mall", 2][SQUARE]
        assert row.visits == 3 and round(sessions_of(row.session_bits)) == 2

    run(use)


def test_what_says_nothing_of_a_place_is_not_counted() -> None:
    async def use(counter: MapUse, rows: Rows, clock_ms: list[int]) -> None:
        await counter.heard("mall", SITE, "a", "surefix", fix())
        await counter.heard("mall", SITE, "a", "surefix", fix(0.1, flag=Flag.FAULT))
        await counter.heard("mall", SITE, "a", "surefix", fix(0.1, source="bluetooth"))
        await counter.heard("mall", SITE, "a", "surefix", replace(fix(0.1), position=None))
        await counter.heard("mall", Site(), "a", "surefix", fix(0.1))
        await counter.heard("mall", SITE, "a", "integrity_ukf", fix(0.1))
        await counter.close()
        assert rows.kept == {}

    run(use)


def test_a_database_that_is_down_loses_nothing_and_stops_nobody() -> None:
    async def use(counter: MapUse, rows: Rows, clock_ms: list[int]) -> None:
        rows.down = True
        await counter.heard("mall", SITE, "a", "surefix", fix(0.1))
        await counter.close()
        await counter.heard("mall", SITE, "b", "surefix", fix(0.1))
        await counter.close()
        rows.down = False
        await counter.flush()
        await counter.flush()
        assert (rows.kept["mall", 2][SQUARE].visits, rows.adding) == (2, 1)

    run(use)


def test_only_this_period_and_the_last_count() -> None:
    async def use(counter: MapUse, rows: Rows, clock_ms: list[int]) -> None:
        await counter.heard("mall", SITE, "a", "surefix", fix(0.1))
        await counter.close()
        assert counter.first_period() == 699 and counter.since_ms() == 699 * PERIOD_MS
        clock_ms[0] += PERIOD_MS
        assert await rows.read("mall", 2, counter.first_period())
        clock_ms[0] += PERIOD_MS
        assert not await rows.read("mall", 2, counter.first_period())

    run(use)


def test_a_map_that_is_no_longer_like_its_survey_is_told_of() -> None:
    told: list[tuple[str, int]] = []

    async def use(counter: MapUse, rows: Rows, clock_ms: list[int]) -> None:
        for number in range(30):
            await counter.heard("mall", SITE, f"before {number}", "surefix", fix(0.01, x_m=5.0))
        await counter.close()
        await counter.judge()
        for number in range(30):
            await counter.heard("mall", SITE, f"after {number}", "surefix", fix(0.9, x_m=15.0))
        await counter.close()
        await counter.judge()
        rows.down = True

    run(use, told)
    assert told == [("mall", 0), ("mall", 1)]
