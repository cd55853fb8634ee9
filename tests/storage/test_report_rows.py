from __future__ import annotations

import asyncio

from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.report_rows import ReportRow, ReportRows
from tests.storage.conftest import Run
from tests.storage.test_watch_list_rows import NOW_MS, mapped

REPORT = ReportRow(b'{"version":2}', b"\x89PNG", 1_700_000_000_000)


def test_a_report_is_stored_with_its_version_and_no_other_has_it(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await mapped(engine)
        rows = ReportRows(engine)
        found = await rows.read("mall", 2)
        assert found is not None
        key, report = found
        assert (key.surveys, key.created_ms, report) == ((), NOW_MS, None)
        assert await rows.body(key.map_id) == b"map"
        assert await rows.add(key.map_id, REPORT)
        assert await rows.read("mall", 2) == (key, REPORT)
        other = await rows.read("mall", 1)
        assert other is not None and other[1] is None
        assert await rows.read("mall", 3) is None and await rows.read("none", 2) is None

    run(use)


def test_of_workers_that_make_the_same_report_the_first_one_stores_it(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await mapped(engine)
        rows = ReportRows(engine)
        found = await rows.read("mall", 2)
        assert found is not None
        stored = await asyncio.gather(*(rows.add(found[0].map_id, REPORT) for _ in range(3)))
        assert sorted(stored) == [False, False, True]
        assert await rows.read("mall", 2) == (found[0], REPORT)

    run(use)
