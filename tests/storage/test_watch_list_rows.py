from __future__ import annotations

import asyncio

from sqlalchemy import func, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.radio_map_rows import BuiltMap, RadioMapRows
from app.storage.survey_rows import NewSurvey, SurveyRows
from app.storage.tables import watch_confirmations, watch_evidence
from app.storage.venue_rows import VenueRows
from app.storage.watch_list_rows import HOUR_MS, WatchedRow, WatchListRows
from tests.storage.conftest import Run

AP, OTHER = 0xA80CCA039DD7, 0xFFFFFFFFFFFF
DAY_MS = 86_400_000
NOW_MS = 1_700_000_000_000
REASONS = {AP: "moved"}


async def mapped(engine: AsyncEngine, versions: int = 2) -> WatchListRows:
    """Lists of a venue `mall` with versions, the last one active."""
    await VenueRows(engine).add("mall", "mall", 0)
    found = await VenueRows(engine).read("mall")
    assert found is not None
    for version in range(1, versions + 1):
        await RadioMapRows(engine).add(found[0].id, BuiltMap(version, (), False, {}, b"map", True), NOW_MS)
    return WatchListRows(engine)


async def revision(engine: AsyncEngine) -> int:
    found = await VenueRows(engine).read("mall")
    assert found is not None
    return found[0].revision


async def noticed(rows: WatchListRows, session: str, now_ms: int = NOW_MS, needed: int = 3) -> frozenset[int]:
    return await rows.notice("mall", 2, session.encode(), REASONS, now_ms, now_ms - DAY_MS, needed, 0.25)


def test_it_takes_so_many_distinct_sessions_and_raises_the_revision_once(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        before = await revision(engine)
        for session in ("a", "b", "a", "b", "a"):
            assert await noticed(rows, session) == frozenset()
        assert (await rows.listed("mall", 2), await revision(engine)) == ([], before)
        assert await noticed(rows, "c", NOW_MS + 1) == {AP}
        assert await rows.listed("mall", 2) == [WatchedRow(AP, "moved", NOW_MS, NOW_MS + 1, 3, None)]
        assert (await rows.watched("mall", 2), await revision(engine)) == (frozenset({AP}), before + 1)
        assert await noticed(rows, "d", NOW_MS + 2) == await noticed(rows, "d", NOW_MS + 3) == frozenset()
        assert await rows.listed("mall", 2) == [WatchedRow(AP, "moved", NOW_MS, NOW_MS + 2, 4, None)]
        assert await revision(engine) == before + 1

    run(use)


def test_sessions_of_longer_ago_do_not_count_and_count_again_when_they_say_it_again(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        for session in ("a", "b"):
            await noticed(rows, session, NOW_MS)
        later_ms = NOW_MS + DAY_MS + 1
        assert await noticed(rows, "c", later_ms) == frozenset()
        assert await noticed(rows, "a", later_ms) == frozenset()
        assert await noticed(rows, "b", later_ms) == {AP}

    run(use)


def test_workers_that_notice_at_once_list_an_access_point_once(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        before = await revision(engine)
        sessions = [f"{n % 4}" for n in range(12)]
        listed = await asyncio.gather(*(noticed(rows, session) for session in sessions))
        assert sorted(map(len, listed)) == [0] * 11 + [1]
        assert [(row.bssid, row.evidence) for row in await rows.listed("mall", 2) or []] == [(AP, 4)]
        assert await revision(engine) == before + 1

    run(use)


def test_what_an_administrator_removed_comes_back_by_hand_only(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        await noticed(rows, "a", needed=1)
        before = await revision(engine)
        assert await rows.remove("mall", 2, AP, NOW_MS + 5)
        assert not await rows.remove("mall", 2, AP, NOW_MS + 6)
        assert (await rows.watched("mall", 2), await revision(engine)) == (frozenset(), before + 1)
        assert await noticed(rows, "b", needed=1) == frozenset()
        assert await rows.watched("mall", 2) == frozenset()
        assert await rows.add("mall", 2, AP, "seen it", NOW_MS + 7) == (
            WatchedRow(AP, "seen it", NOW_MS + 7, NOW_MS + 7, 2, None),
            True,
        )
        assert (await rows.watched("mall", 2), await revision(engine)) == (frozenset({AP}), before + 2)

    run(use)


def test_adding_what_is_watched_changes_nothing(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        first = await rows.add("mall", 2, OTHER, "by hand", NOW_MS)
        before = await revision(engine)
        again = await rows.add("mall", 2, OTHER, "another", NOW_MS + 1)
        assert first is not None and again == (first[0], False)
        assert await revision(engine) == before

    run(use)


def test_every_version_has_a_list_of_its_own_and_what_does_not_exist_has_none(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        await rows.add("mall", 2, AP, "by hand", NOW_MS)
        assert await rows.listed("mall", 1) == []
        assert await rows.watched("mall", 1) == await rows.watched("none", 1) == frozenset()
        for venue, version in (("mall", 3), ("none", 2)):
            assert await rows.listed(venue, version) is None
            assert await rows.add(venue, version, AP, "x", NOW_MS) is None
            assert not await rows.remove(venue, version, AP, NOW_MS)
            assert await rows.notice(venue, version, b"a", REASONS, NOW_MS, 0, 1, 0.25) == frozenset()

    run(use)


def test_those_who_confirm_an_access_point_outvote_a_few_who_exclude_it_until_their_hour_is_over(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        for _ in range(3):
            await rows.confirm("mall", 2, {AP: 4, OTHER: 1}, NOW_MS)
        for number in range(3):
            assert not await noticed(rows, f"early {number}")
        await rows.confirm("mall", 1, {AP: 100}, NOW_MS)
        await rows.confirm("none", 1, {AP: 100}, NOW_MS)
        assert await noticed(rows, "the fourth of sixteen") == {AP}
        other = {OTHER: "moved"}
        later_ms = NOW_MS + DAY_MS + 2 * HOUR_MS
        await rows.confirm("mall", 2, {OTHER: 1000}, NOW_MS)
        for number in range(3):
            session = f"late {number}".encode()
            listed = await rows.notice("mall", 2, session, other, later_ms, later_ms - DAY_MS, 3, 0.25)
        assert listed == {OTHER}

    run(use)


def test_what_counts_no_longer_is_forgotten(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        await rows.confirm("mall", 2, {AP: 1}, NOW_MS)
        await rows.confirm("mall", 2, {AP: 1}, NOW_MS - HOUR_MS)
        await noticed(rows, "old", NOW_MS)
        await noticed(rows, "new", NOW_MS + 10)
        await rows.forget_evidence(NOW_MS + 10)
        async with engine.connect() as connection:
            assert await connection.scalar(select(func.count()).select_from(watch_evidence)) == 1
            assert await connection.scalar(select(func.count()).select_from(watch_confirmations)) == 1

    run(use)


def test_a_new_version_watches_what_the_one_in_use_does_but_for_what_was_surveyed_after(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows, again = await mapped(engine), 0x001122334455
        found = await VenueRows(engine).read("mall")
        assert found is not None
        venue_id = found[0].id
        surveyed = []
        for created_ms in (NOW_MS - DAY_MS, NOW_MS + DAY_MS):
            survey = NewSurvey("json", {}, 0, 0, created_ms)
            surveyed.append(await SurveyRows(engine).add(venue_id, survey, (), {}))
        for bssid in (AP, OTHER, again):
            await rows.add("mall", 2, bssid, "moved", NOW_MS)
        await rows.add("mall", 2, 5, "taken off", NOW_MS)
        await rows.remove("mall", 2, 5, NOW_MS)
        heard = {AP: 0, again: 1, 5: 0}  # the other was not heard at all
        built = BuiltMap(3, tuple(surveyed), True, {}, b"map", True, heard)
        await RadioMapRows(engine).add(venue_id, built, NOW_MS + 2 * DAY_MS)
        listed = await rows.listed("mall", 3)
        assert listed is not None
        assert {(one.bssid, one.reason, one.first_seen_ms) for one in listed} == {
            (AP, "moved", NOW_MS),
            (OTHER, "moved", NOW_MS),
        }
        assert await rows.watched("mall", 2) == {AP, OTHER, again}

    run(use)


def test_a_version_that_is_not_in_use_hands_nothing_on(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = await mapped(engine)
        await rows.add("mall", 1, AP, "moved", NOW_MS)
        found = await VenueRows(engine).read("mall")
        assert found is not None
        await RadioMapRows(engine).add(found[0].id, BuiltMap(3, (), False, {}, b"map", True), NOW_MS)
        assert await rows.listed("mall", 3) == []

    run(use)
