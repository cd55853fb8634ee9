from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from sqlalchemy import func, insert, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.radio_map_rows import BuiltMap, OutdatedError
from app.storage.survey_rows import CHUNK, NewSurvey, SurveyRows
from app.storage.tables import fingerprints, floors, radio_maps, surveys, venues
from app.survey.spool import Row, fingerprint_of
from app.wifi.fingerprint_codec import pack_readings
from tests.storage.conftest import Run

SURVEY = NewSurvey("csv", {"brand": "OPPO"}, accepted=3, rejected=1, created_ms=7)
READINGS = pack_readings(np.array([1, 2]), np.array([-40.0, -50.5]))


def rows(count: int, floor: str = "F1") -> list[Row]:
    return [(floor, f"walk-{n % 3}", 1000.0 + n, float(n), 2.5, READINGS) for n in range(count)]


async def make_venue(engine: AsyncEngine, venue: str = "mall") -> tuple[int, dict[str, int]]:
    """Keys of a venue and of its floors F1 (georeferenced) and F2."""
    async with engine.begin() as connection:
        made = insert(venues).values(venue=venue, name=venue, revision=1, created_ms=0).returning(venues.c.id)
        key = await connection.scalar(made)
        size = {"venue_id": key, "width_m": 100.0, "height_m": 60.0}
        place = {"latitude_deg": 30.0, "longitude_deg": 120.0, "rotation_rad": 0.5}
        nowhere = dict.fromkeys(place)
        new = [
            {"floor": "F1", "name": "one", "level": 0, **size, **place},
            {"floor": "F2", "name": "two", "level": 1, **size, **nowhere},
        ]
        await connection.execute(insert(floors), new)
        named = (await connection.execute(select(floors.c.floor, floors.c.id).where(floors.c.venue_id == key))).all()
    assert key is not None
    return key, {row[0]: row[1] for row in named}


async def counts(engine: AsyncEngine) -> list[int]:
    """Surveys, fingerprints and versions."""
    async with engine.connect() as connection:
        tables = (surveys, fingerprints, radio_maps)
        return [await connection.scalar(select(func.count()).select_from(table)) or 0 for table in tables]


async def stored(store: SurveyRows, ids: list[int]) -> list[list[Row]]:
    return [chunk async for chunk in store.fingerprints(ids)]


def test_a_survey_comes_back_as_it_was_stored(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, floor_ids = await make_venue(engine)
        store = SurveyRows(engine)
        first = await store.add(key, SURVEY, rows(2), floor_ids)
        second = await store.add(key, SURVEY, rows(1, "F2"), floor_ids)
        assert await store.ids(key) == [first, second]
        assert await stored(store, [second, first]) == [rows(1, "F2"), rows(2)]
        one = fingerprint_of((await stored(store, [first]))[0][1])
        assert (one.floor, one.walk, one.x_m, one.time_s) == ("F1", "walk-1", 1.0, 1001.0)
        assert (one.bssid.tolist(), one.rssi_dbm.tolist()) == ([1, 2], [-40.0, -50.5])

    run(use)


def test_many_fingerprints_come_in_chunks(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, floor_ids = await make_venue(engine)
        store = SurveyRows(engine)
        survey = await store.add(key, SURVEY, iter(rows(2 * CHUNK + 1)), floor_ids)
        chunks = await stored(store, [survey])
        assert [len(chunk) for chunk in chunks] == [CHUNK, CHUNK, 1]
        assert [row for chunk in chunks for row in chunk] == rows(2 * CHUNK + 1)

    run(use)


def test_a_survey_that_breaks_off_leaves_nothing(run: Run) -> None:
    class BrokenOffError(Exception):
        pass

    def breaking() -> Iterator[Row]:
        yield from rows(CHUNK + 5)
        raise BrokenOffError

    async def use(engine: AsyncEngine) -> None:
        key, floor_ids = await make_venue(engine)
        store = SurveyRows(engine)
        built = BuiltMap(1, (), True, {}, b"map", active=True)
        for with_map in (None, built):
            with pytest.raises(BrokenOffError):
                await store.add(key, SURVEY, breaking(), floor_ids, with_map)
        assert await counts(engine) == [0, 0, 0]
        async with engine.connect() as connection:
            assert (await connection.execute(select(venues.c.revision, venues.c.active_version))).all() == [(1, None)]
        await store.add(key, SURVEY, rows(1), floor_ids, built)
        assert await counts(engine) == [1, 1, 1]

    run(use)


def test_a_radio_map_lands_with_its_survey_and_is_active_at_once(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, floor_ids = await make_venue(engine)
        store = SurveyRows(engine)
        first = await store.add(key, SURVEY, rows(1), floor_ids)
        built = BuiltMap(1, (first,), True, {"n": 2}, b"map", active=True)
        second = await store.add(key, SURVEY, rows(1), floor_ids, built)
        async with engine.connect() as connection:
            (row,) = (await connection.execute(select(radio_maps))).all()
            venue = (await connection.execute(select(venues))).one()
        assert (row.version, row.surveys, row.summary, row.body) == (1, [first, second], {"n": 2}, b"map")
        assert (venue.active_version, venue.revision) == (1, 2)

    run(use)


@pytest.mark.parametrize("reason", ["another survey came", "the number was given away"])
def test_a_radio_map_that_is_outdated_takes_its_survey_with_it(run: Run, reason: str) -> None:
    async def use(engine: AsyncEngine) -> None:
        key, floor_ids = await make_venue(engine)
        store = SurveyRows(engine)
        built = BuiltMap(1, (), True, {}, b"map", active=True)
        if reason == "another survey came":
            await store.add(key, SURVEY, rows(1), floor_ids)
        else:
            made = {"venue_id": key, "version": 1, "surveys": [], "summary": {}, "body": b"", "created_ms": 0}
            async with engine.begin() as connection:
                await connection.execute(insert(radio_maps).values(made))
        before = await counts(engine)
        with pytest.raises(OutdatedError):
            await store.add(key, SURVEY, rows(1), floor_ids, built)
        assert await counts(engine) == before

    run(use)


def test_surveys_of_one_venue_are_not_those_of_another(run: Run) -> None:
    async def use(engine: AsyncEngine) -> Any:
        store = SurveyRows(engine)
        mall, floor_ids = await make_venue(engine)
        station, _ = await make_venue(engine, "station")
        await store.add(mall, SURVEY, rows(1), floor_ids)
        assert await store.ids(station) == []

    run(use)
