from __future__ import annotations

import asyncio

import pytest
from sqlalchemy.ext.asyncio import AsyncEngine

from app.errors import DependencyDown
from app.storage.radio_map_rows import ActiveMap, BuiltMap, OutdatedError, RadioMapRows
from tests.storage.conftest import Run
from tests.storage.test_survey_rows import make_venue


def built(version: int, active: bool = True, surveys: tuple[int, ...] = ()) -> BuiltMap:
    return BuiltMap(version, surveys, False, {"fingerprints": version}, b"map %d" % version, active)


def test_a_venue_without_a_map_has_a_revision_and_a_venue_that_is_none_has_nothing(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        await make_venue(engine)
        store = RadioMapRows(engine)
        assert await store.active("mall") == ActiveMap(1, None, None)
        assert await store.active("nowhere") is None

    run(use)


def test_versions_are_numbered_and_the_active_one_is_read_with_its_revision(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, _ = await make_venue(engine)
        other, _ = await make_venue(engine, "station")
        store = RadioMapRows(engine)
        await store.add(key, built(1), 100)
        await store.add(key, built(2), 200)
        await store.add(other, built(1), 300)
        assert await store.active("mall") == ActiveMap(3, 2, b"map 2")
        assert await store.newest(key) == 2
        assert [(one.version, one.active, one.created_ms, one.summary) for one in await store.listed(key)] == [
            (1, False, 100, {"fingerprints": 1}),
            (2, True, 200, {"fingerprints": 2}),
        ]

    run(use)


def test_a_version_that_is_not_published_changes_nothing_for_phones(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, _ = await make_venue(engine)
        store = RadioMapRows(engine)
        await store.add(key, built(1, active=False, surveys=(4, 7)), 100)
        assert await store.active("mall") == ActiveMap(1, None, None)
        (one,) = await store.listed(key)
        assert (one.active, list(one.surveys)) == (False, [4, 7])

    run(use)


def test_any_version_can_become_the_active_one_and_each_change_is_a_revision(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, _ = await make_venue(engine)
        store = RadioMapRows(engine)
        await store.add(key, built(1), 100)
        await store.add(key, built(2), 200)
        assert await store.activate(key, 1)
        assert await store.active("mall") == ActiveMap(4, 1, b"map 1")
        assert not await store.activate(key, 3)
        assert await store.active("mall") == ActiveMap(4, 1, b"map 1")

    run(use)


def test_a_number_that_was_given_away_is_refused(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, _ = await make_venue(engine)
        store = RadioMapRows(engine)
        await store.add(key, built(1), 100)
        for number in (1, 3):
            with pytest.raises(OutdatedError):
                await store.add(key, built(number), 200)
        assert [one.created_ms for one in await store.listed(key)] == [100]

    run(use)


def test_of_many_who_publish_one_number_at_once_one_succeeds(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, _ = await make_venue(engine)
        store = RadioMapRows(engine)
        outcomes = await asyncio.gather(*(store.add(key, built(1), n) for n in range(6)), return_exceptions=True)
        assert outcomes.count(None) == 1
        assert all(one is None or isinstance(one, OutdatedError | DependencyDown) for one in outcomes)
        assert len(await store.listed(key)) == 1
        assert await store.active("mall") == ActiveMap(2, 1, b"map 1")

    run(use)
