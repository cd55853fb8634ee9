from __future__ import annotations

import asyncio
import dataclasses
from typing import Any

import pytest
from sqlalchemy.ext.asyncio import AsyncEngine

from app.errors import DependencyDown
from app.storage.database import connect
from app.storage.migration import migrate
from app.storage.phone_rows import PhoneRow, PhoneRows
from app.storage.session_rows import EvidenceRow, FixRow, SessionRows
from app.storage.venue_rows import VenueRows
from tests.postgresql_process import PostgresqlProcess
from tests.storage.conftest import Run

HOURS = 1.0
LIFETIME_MS = 3_600_000
NOW_MS = 1_700_000_000_000


async def opened(engine: AsyncEngine, session: str, venue: str = "mall", now_ms: int = NOW_MS) -> SessionRows:
    """A session without batches, in a venue that is made where it is missing."""
    rows = SessionRows(engine)
    await VenueRows(engine).add(venue, venue, 0)
    found = await rows.venue(venue)
    assert found is not None
    values: dict[str, Any] = {"session": session, "venue_id": found[0], "method": "surefix", "alert_limit_m": 10.0}
    values |= {"risk": 0.01, "floor_hint": None, "start": {"x_m": 1.5, "floor": "F1"}, "device": {"brand": "é😀"}}
    values |= {"created_ms": now_ms, "expires_ms": now_ms + LIFETIME_MS, "sequence": -1, "state": b"\0\xff"}
    await rows.open({**values, "ticket_key": b"k"})
    return rows


def fix(sequence: int) -> FixRow:
    return FixRow(sequence, 1000 * sequence, b'{"sequence":%d}' % sequence)


def test_a_fix_is_stored_with_its_state_or_not_at_all(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await opened(engine, "a")
        assert await rows.add_fix("a", -1, fix(0), b"state 0", NOW_MS)
        assert not await rows.add_fix("a", -1, fix(1), b"state 1", NOW_MS)
        row = await rows.read("a")
        assert row is not None and (row.sequence, row.newest_ms, row.expires_ms) == (0, 0, NOW_MS)
        assert await rows.read_state("a", 0) == b"state 0"
        assert await rows.read_state("a", 1) is None
        assert await rows.read_track("a", -1, 10) == [fix(0)]

    run(use)


def test_evidence_is_stored_with_its_fix_and_erased_with_the_session(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await opened(engine, "a")
        made = [dataclasses.replace(fix(0), evidence=b"\0\xff"), fix(1), dataclasses.replace(fix(2), evidence=b"")]
        for one in made:
            assert await rows.add_fix("a", one.sequence - 1, one, b"", NOW_MS)
        assert not await rows.add_fix("a", 0, dataclasses.replace(fix(1), evidence=b"late"), b"", NOW_MS)
        told = [EvidenceRow(0, 0, b"\0\xff"), EvidenceRow(1, 1000, None), EvidenceRow(2, 2000, b"")]
        assert await rows.read_evidence("a") == told
        await rows.erase("a")
        assert await rows.read_evidence("a") == []

    run(use)


def test_of_workers_that_advance_at_once_one_wins(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await opened(engine, "a")
        for sequence in range(5):
            tried = [rows.add_fix("a", sequence - 1, fix(sequence), b"", NOW_MS) for _ in range(4)]
            assert sorted(await asyncio.gather(*tried)) == [False, False, False, True]

    run(use)


def test_an_erased_session_takes_its_fixes_along(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await opened(engine, "a")
        await rows.add_fix("a", -1, fix(0), b"", NOW_MS)
        assert await rows.erase("a") is True
        assert await rows.erase("a") is False
        assert await rows.read("a") is None
        assert await rows.read_track("a", -1, 10) == []

    run(use)


def test_purging_empties_what_is_over_and_forgets_it_in_the_end(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await opened(engine, "over")
        await opened(engine, "live", now_ms=NOW_MS + LIFETIME_MS)
        await rows.add_fix("over", -1, fix(0), b"state", NOW_MS)
        assert await rows.purge(NOW_MS + 1, NOW_MS - 1) == 1
        assert await rows.purge(NOW_MS + 1, NOW_MS - 1) == 0
        assert await rows.read("over") is not None
        assert await rows.read_state("over", 0) == b""
        assert await rows.read_track("over", -1, 10) == []
        await rows.purge(NOW_MS + 1, NOW_MS + 1)
        assert await rows.read("over") is None
        assert await rows.read_state("live", -1) == b"\0\xff"

    run(use)


def test_the_phones_of_a_venue_are_those_heard_of_since_with_their_newest_fix(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        for session in ("silent", "walking", "new"):
            rows = await opened(engine, session)
        await opened(engine, "elsewhere", "other")
        await rows.add_fix("silent", -1, fix(0), b"", NOW_MS + LIFETIME_MS)
        for sequence in range(3):
            await rows.add_fix("walking", sequence - 1, fix(sequence), b"", NOW_MS + 5000 + LIFETIME_MS)
        await rows.add_fix("elsewhere", -1, fix(0), b"", NOW_MS + 5000 + LIFETIME_MS)
        phones = PhoneRows(engine, HOURS)
        assert await phones.newest("mall", NOW_MS + 1000) == [PhoneRow("walking", NOW_MS + 5000, fix(2).body)]
        assert await phones.newest("none", 0) is None

    run(use)


def test_while_postgresql_is_away_it_is_told_and_then_everything_goes_on() -> None:
    server = PostgresqlProcess()
    server.start()
    try:
        url = server.new_database()
        migrate(url)

        async def use() -> None:
            engine = connect(url)
            rows = await opened(engine, "a")
            await rows.add_fix("a", -1, fix(0), b"", NOW_MS)
            server.kill()
            for attempt in (rows.read("a"), rows.add_fix("a", 0, fix(1), b"", NOW_MS), rows.erase("a")):
                with pytest.raises(DependencyDown):
                    await attempt
            server.start()
            assert await rows.add_fix("a", 0, fix(1), b"", NOW_MS)
            assert await rows.read_track("a", -1, 10) == [fix(0), fix(1)]
            await engine.dispose()

        asyncio.run(use())
    finally:
        server.remove()
