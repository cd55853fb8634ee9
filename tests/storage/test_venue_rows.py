from __future__ import annotations

import asyncio
from typing import Any

import pytest
from sqlalchemy.ext.asyncio import AsyncEngine

from app.floorplan.georeference import Georeference
from app.storage.venue_rows import VenueRows
from tests.storage.conftest import Run

FLOOR: dict[str, Any] = {
    "name": "Ground floor",
    "level": 0,
    "width_m": 240.5,
    "height_m": 176.25,
    "latitude_deg": 30.25,
    "longitude_deg": 120.5,
    "rotation_rad": 0.125,
    "plan": b'{"type":"FeatureCollection","features":[]}',
}


def test_what_was_stored_is_read_back(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = VenueRows(engine)
        assert await rows.add("mall", "Café 😀", 1_700_000_000_123)
        assert await rows.put_floor("mall", "F1", FLOOR) is True
        assert await rows.put_floor("mall", "B1", {**FLOOR, "level": -1, "plan": None, "latitude_deg": None}) is True
        found = await rows.read("mall")
        assert found is not None
        venue, (basement, ground) = found
        assert (venue.venue, venue.name, venue.created_ms) == ("mall", "Café 😀", 1_700_000_000_123)
        assert (basement.floor, basement.level, basement.has_plan, basement.latitude_deg) == ("B1", -1, False, None)
        assert (ground.width_m, ground.latitude_deg, ground.rotation_rad) == (240.5, 30.25, 0.125)
        assert (ground.has_plan, ground.has_image) == (True, False)
        assert await rows.read_plan("mall", "F1") == FLOOR["plan"]
        assert await rows.read_plan("mall", "B1") is None

    run(use)


def test_a_venue_that_is_there_is_not_made_again(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = VenueRows(engine)
        made = await asyncio.gather(*(rows.add("mall", f"Mall {n}", n) for n in range(4)))
        assert sorted(made) == [False, False, False, True]
        assert len(await rows.listed()) == 1

    run(use)


def test_every_change_of_a_floor_raises_the_revision_and_replaces_all_but_the_image(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = VenueRows(engine)
        await rows.add("mall", "Mall", 0)
        await rows.put_floor("mall", "F1", FLOOR)
        assert await rows.put_image("mall", "F1", b"png")
        assert await rows.put_floor("mall", "F1", {**FLOOR, "plan": None, "level": 3}) is False
        found = await rows.read("mall")
        assert found is not None
        venue, (floor,) = found
        assert venue.revision == 3
        assert (floor.level, floor.has_plan, floor.has_image) == (3, False, True)
        assert await rows.read_image("mall", "F1") == b"png"
        assert await rows.revisions() == [("mall", 3)]

    run(use)


def test_floors_that_are_put_at_once_all_count(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = VenueRows(engine)
        await rows.add("mall", "Mall", 0)
        made = await asyncio.gather(*(rows.put_floor("mall", f"F{n % 3}", FLOOR) for n in range(9)))
        assert sorted(map(str, made)) == ["False"] * 6 + ["True"] * 3
        assert await rows.revisions() == [("mall", 10)]

    run(use)


def test_floors_are_those_of_one_venue_or_of_all(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = VenueRows(engine)
        for venue in ("mall", "station"):
            await rows.add(venue, venue, 0)
            for floor, level in (("F2", 1), ("F1", 0)):
                await rows.put_floor(venue, floor, {**FLOOR, "level": level})
        found = await rows.read("station")
        assert found is not None
        assert await rows.key("station") == found[0].id and await rows.key("nowhere") is None
        assert [(row.venue, row.floor) for row in found[1]] == [("station", "F1"), ("station", "F2")]
        every = await rows.floors()
        assert [(row.venue, row.floor) for row in every] == [
            ("mall", "F2"),
            ("mall", "F1"),
            ("station", "F2"),
            ("station", "F1"),
        ]
        assert every[3:1:-1] == found[1]

    run(use)


@pytest.mark.parametrize("missing", ["latitude_deg", "longitude_deg", "rotation_rad"])
def test_a_floor_has_a_georeference_only_if_all_of_it_is_known(run: Run, missing: str) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = VenueRows(engine)
        await rows.add("mall", "Mall", 0)
        await rows.put_floor("mall", "F1", FLOOR)
        await rows.put_floor("mall", "F2", {**FLOOR, missing: None})
        places = {row.floor: row.georeference for row in await rows.floors()}
        assert places == {"F1": Georeference(30.25, 120.5, 0.125), "F2": None}

    run(use)


def test_what_is_unknown_is_told_and_nothing_is_made(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = VenueRows(engine)
        assert await rows.read("mall") is None
        assert await rows.put_floor("mall", "F1", FLOOR) is None
        assert await rows.put_image("mall", "F1", b"png") is False
        assert await rows.read_image("mall", "F1") is None
        assert await rows.listed() == []

    run(use)
