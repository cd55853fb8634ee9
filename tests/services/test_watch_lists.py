from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import event, func, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.errors import DependencyDown, InvalidInput, NotFound
from app.observations import Excluded
from app.services.watch_lists import CONFIRMING_SCANS, WATCHED_MS, WatchLists, WatchState
from app.storage.database import connect
from app.storage.migration import migrate
from app.storage.tables import watch_confirmations
from app.storage.watch_list_rows import WatchListRows
from tests.storage.test_watch_list_rows import AP, NOW_MS, OTHER, mapped

Use = Callable[[WatchLists, AsyncEngine, list[int]], Awaitable[Any]]
MOVED = (Excluded("moved", bssid=AP),)


def run(folder: Path, use: Use, needed: int = 3) -> None:
    """Use the lists of a new database; the list of one number is the clock."""
    url = f"sqlite:///{folder / 'test.db'}"
    migrate(url)

    async def with_lists() -> None:
        engine = connect(url)
        try:
            clock_ms = [NOW_MS]
            await use(WatchLists(await mapped(engine), lambda: clock_ms[0], needed, 0.25, 24.0), engine, clock_ms)
        finally:
            await engine.dispose()

    asyncio.run(with_lists())


def test_an_access_point_is_watched_for_48_hours_and_then_permanent_until_it_is_removed(tmp_path: Path) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        for session in "abc":
            await lists.notice("mall", 2, session, MOVED)
        for passed_ms, state in ((0, WatchState.WATCHED), (WATCHED_MS, WatchState.PERMANENT)):
            clock_ms[0] = NOW_MS + passed_ms
            assert [(one.row.bssid, one.state) for one in await lists.listed("mall", 2)] == [(AP, state)]
        await lists.remove("mall", 2, "A8-0C-CA-03-9D-D7")
        assert [one.state for one in await lists.listed("mall", 2)] == [WatchState.REMOVED]
        with pytest.raises(NotFound):
            await lists.remove("mall", 2, "a8:0c:ca:03:9d:d7")

    run(tmp_path, use)


@pytest.mark.parametrize("reason", ["moved", "moved: 34 m away", "spoofed, twice", "duplicated", "vanished", "swapped"])
def test_reasons_of_the_access_point_itself_count(tmp_path: Path, reason: str) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        await lists.notice("mall", 2, "a", (Excluded(reason, bssid=AP),))
        assert [one.row.reason for one in await lists.listed("mall", 2)] == [reason]

    run(tmp_path, use, needed=1)


@pytest.mark.parametrize("reason", ["watched", "weak", "stale", "", "unmoved", "far from where the steps lead"])
def test_other_reasons_and_exclusions_of_no_access_point_do_not(tmp_path: Path, reason: str) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        await lists.notice("mall", 2, "a", (Excluded(reason, bssid=AP), Excluded("moved", observation="wifi")))
        assert await lists.listed("mall", 2) == []

    run(tmp_path, use, needed=1)


def test_a_session_that_says_the_same_again_costs_no_database(tmp_path: Path) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        statements: list[str] = []
        event.listen(engine.sync_engine, "before_cursor_execute", lambda *heard: statements.append(heard[2]))
        await lists.notice("mall", 2, "a", MOVED)
        assert statements
        statements.clear()
        for _ in range(100):
            await lists.notice("mall", 2, "a", MOVED)
            await lists.notice("mall", 2, "b", ())
        assert statements == []
        await lists.notice("mall", 2, "a", (*MOVED, Excluded("vanished", bssid=OTHER)))
        assert statements

    run(tmp_path, use)


@pytest.mark.parametrize("away", [False, True])
def test_what_most_sessions_hear_as_it_was_surveyed_is_not_listed_for_the_few_that_exclude_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, away: bool
) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        async def gone(*_: Any) -> None:
            raise DependencyDown("away")

        for number in range(10):
            for _ in range(CONFIRMING_SCANS - 1):
                lists.confirm("mall", 2, f"sound {number}", (AP, OTHER))
            lists.confirm("mall", 2, f"sound {number}", (AP,) * 9)
        with monkeypatch.context() as patched:
            if away:
                patched.setattr(WatchListRows, "confirm", gone)
                await lists.notice("mall", 2, "a", MOVED)
        for session in "abc":
            await lists.notice("mall", 2, session, (*MOVED, Excluded("moved", bssid=OTHER)))
        assert [one.row.bssid for one in await lists.listed("mall", 2)] == [OTHER]
        for session in "de":
            await lists.notice("mall", 2, session, MOVED)
        assert {one.row.bssid for one in await lists.listed("mall", 2)} == {AP, OTHER}

    run(tmp_path, use)


def test_confirmations_are_written_down_in_time_even_if_nothing_is_excluded(tmp_path: Path) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        lists.confirm("mall", 2, "a", (AP,) * CONFIRMING_SCANS)
        await lists.forget()
        async with engine.connect() as connection:
            assert await connection.scalar(select(func.sum(watch_confirmations.c.sessions))) == 1

    run(tmp_path, use)


def test_while_the_database_is_away_nothing_is_lost_and_the_batch_does_not_fail(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        async def away(*_: Any) -> frozenset[int]:
            raise DependencyDown("away")

        with monkeypatch.context() as patched:
            patched.setattr(WatchListRows, "notice", away)
            await lists.notice("mall", 2, "a", MOVED)
        assert "later" in caplog.text
        await lists.notice("mall", 2, "a", MOVED)
        assert [one.row.bssid for one in await lists.listed("mall", 2)] == [AP]

    run(tmp_path, use, needed=1)


def test_what_is_no_address_and_what_does_not_exist_is_refused(tmp_path: Path) -> None:
    async def use(lists: WatchLists, engine: AsyncEngine, clock_ms: list[int]) -> None:
        with pytest.raises(InvalidInput):
            await lists.add("mall", 2, "a8:0c", "by hand")
        for attempt in (
            lists.add("mall", 3, "a80cca039dd7", "by hand"),
            lists.listed("none", 1),
            lists.remove("mall", 2, "nonsense"),
        ):
            with pytest.raises(NotFound):
                await attempt

    run(tmp_path, use)
