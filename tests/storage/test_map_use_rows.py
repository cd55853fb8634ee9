from __future__ import annotations

import asyncio

from sqlalchemy import delete
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.map_use_rows import MapUseRows, UsedSquare, UseRow
from app.storage.tables import venues
from tests.storage.conftest import Run
from tests.storage.test_watch_list_rows import mapped

HERE, THERE, LATER = UsedSquare("F1", -1, 2, 5), UsedSquare("F1", 0, 2, 5), UsedSquare("F1", -1, 2, 6)
ONE = UseRow(4, 1, 1, -2.5, 6.25, 1 << 62, 900)
OTHER = UseRow(3, 0, 1, -2.0, 4.0, 1, 800)


def test_workers_add_up_and_neither_an_older_time_nor_a_bit_is_lost(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await mapped(engine)
        rows = MapUseRows(engine)
        await rows.add({("mall", 2): {HERE: ONE, THERE: OTHER}})
        await asyncio.gather(*(rows.add({("mall", 2): {HERE: OTHER, THERE: ONE}}) for _ in range(4)))
        both = UseRow(4 + 4 * 3, 1, 5, -2.5 - 4 * 2.0, 6.25 + 4 * 4.0, (1 << 62) | 1, 900)
        found = await rows.read("mall", 2, 5)
        assert found[HERE] == both
        assert (found[THERE].scans, found[THERE].last_ms) == (3 + 4 * 4, 900)

    run(use)


def test_versions_are_apart_and_what_is_of_none_is_dropped(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await mapped(engine)
        rows = MapUseRows(engine)
        await rows.add({("mall", 1): {HERE: ONE}, ("mall", 9): {HERE: ONE}, ("gone", 1): {HERE: ONE}})
        assert await rows.read("mall", 1, 0) == {HERE: ONE}
        assert await rows.read("mall", 2, 0) == await rows.read("gone", 1, 0) == {}

    run(use)


def test_periods_that_are_over_do_not_count_and_can_be_forgotten(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await mapped(engine)
        rows = MapUseRows(engine)
        await rows.add({("mall", 2): {HERE: ONE, LATER: OTHER}})
        assert await rows.read("mall", 2, 6) == {LATER: OTHER}
        await rows.forget(6)
        assert await rows.read("mall", 2, 0) == {LATER: OTHER}

    run(use)


def test_use_goes_with_its_venue(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await mapped(engine)
        rows = MapUseRows(engine)
        await rows.add({("mall", 2): {HERE: ONE}})
        async with engine.begin() as connection:
            await connection.execute(delete(venues))
        await mapped(engine)
        assert await rows.read("mall", 2, 0) == {}

    run(use)
