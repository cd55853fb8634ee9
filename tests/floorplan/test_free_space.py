"""Where walkers can be: what the plan leaves free, what surveyors have shown to be open, and never a plan that lies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from app.floorplan.free_space import NO_PLAN, FreeSpace, free_space
from app.floorplan.georeference import Georeference

PLACE = Georeference(50.0, 10.0, 0.0)
SIZE_M = 40.0, 20.0


def drawn(*rectangles: tuple[float, float, float, float]) -> dict[str, Any]:
    """A plan of rectangles (west, south, east, north) in metres of the frame; the first is the outline."""
    features = []
    for west, south, east, north in rectangles:
        corners = [(west, south), (east, south), (east, north), (west, north), (west, south)]
        ring = [list(reversed(PLACE.to_wgs84(x_m, y_m))) for x_m, y_m in corners]
        features.append({"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}})
    return {"type": "FeatureCollection", "features": features}


OUTLINE, NORTH_ROOM = (0.0, 0.0, 40.0, 20.0), (0.0, 10.0, 40.0, 20.0)
CORRIDOR = np.column_stack([np.linspace(1.0, 39.0, 60), np.full(60, 5.0)])


def at(space: FreeSpace, x_m: float, y_m: float) -> bool:
    return bool(space.cells[int(y_m / space.cell_m), int(x_m / space.cell_m)])


def test_rooms_that_nobody_surveyed_are_walls_and_the_rest_of_the_outline_is_free() -> None:
    space = free_space(drawn(OUTLINE, NORTH_ROOM), PLACE, SIZE_M, CORRIDOR)
    assert at(space, 20.0, 5.0) and at(space, 3.0, 9.0)
    assert not at(space, 20.0, 15.0)


def test_a_room_that_surveyors_walked_deep_into_is_open() -> None:
    west, east, inside = (0.0, 10.0, 20.0, 20.0), (20.0, 10.0, 40.0, 20.0), np.array([[9.0, 15.0]] * 3)
    many = np.tile(CORRIDOR, (3, 1))
    space = free_space(drawn(OUTLINE, west, east), PLACE, SIZE_M, np.concatenate([many, inside]))
    assert at(space, 15.0, 18.0)
    assert not at(space, 30.0, 18.0)


def test_where_surveyors_went_into_rooms_the_rooms_that_they_left_out_are_open_too() -> None:
    rooms = (0.0, 10.0, 20.0, 20.0), (20.0, 10.0, 40.0, 20.0)
    inside = np.column_stack([np.linspace(4.0, 16.0, 12), np.full(12, 15.0)])
    entered = free_space(drawn(OUTLINE, *rooms), PLACE, SIZE_M, np.concatenate([CORRIDOR, inside]))
    passed_by = free_space(drawn(OUTLINE, *rooms), PLACE, SIZE_M, CORRIDOR)
    assert at(entered, 30.0, 15.0)
    assert not at(passed_by, 30.0, 15.0)


def test_places_just_inside_a_room_open_their_surroundings_and_not_the_room() -> None:
    grazing = np.array([[10.0, 10.4], [12.0, 10.4], [14.0, 10.4], [16.0, 10.4]])
    space = free_space(drawn(OUTLINE, NORTH_ROOM), PLACE, SIZE_M, np.concatenate([CORRIDOR, grazing]))
    assert at(space, 12.0, 10.6)
    assert not at(space, 12.0, 13.0)


def test_a_plan_that_the_survey_contradicts_counts_for_nothing() -> None:
    elsewhere = drawn((0.0, 10.0, 40.0, 20.0))
    assert free_space(elsewhere, PLACE, SIZE_M, CORRIDOR) is NO_PLAN


@pytest.mark.parametrize("plan", [None, {"type": "FeatureCollection", "features": []}])
def test_without_a_plan_everything_is_free(plan: dict[str, Any] | None) -> None:
    assert free_space(plan, PLACE, SIZE_M, CORRIDOR) is NO_PLAN


def test_a_plan_that_cannot_be_placed_or_a_floor_that_nobody_surveyed_has_no_walls() -> None:
    plan = drawn(OUTLINE, NORTH_ROOM)
    assert free_space(plan, None, SIZE_M, CORRIDOR) is NO_PLAN
    assert free_space(plan, PLACE, SIZE_M, np.empty((0, 2))) is NO_PLAN


def test_places_outside_of_the_frame_are_left_out() -> None:
    far = np.concatenate([CORRIDOR, [[-5.0, 3.0], [400.0, 3.0]]])
    assert at(free_space(drawn(OUTLINE, NORTH_ROOM), PLACE, SIZE_M, far), 20.0, 5.0)


def test_a_large_floor_is_held_in_a_bounded_number_of_cells() -> None:
    space = free_space(drawn((0.0, 0.0, 5000.0, 4000.0)), PLACE, (5000.0, 4000.0), CORRIDOR)
    assert space.cells.size <= 4_010_000
    assert space.cell_m > 2.0


@pytest.mark.parametrize(
    "rooms", [[OUTLINE] * 20_000, [(0.0, 0.0, 10_000.0, 10_000.0)] * 40], ids=["many rooms", "rooms that cover it"]
)
def test_a_plan_that_would_take_long_to_draw_has_no_walls(rooms: list[tuple[float, float, float, float]]) -> None:
    plan = drawn((0.0, 0.0, 10_000.0, 10_000.0), *rooms)
    assert free_space(plan, PLACE, (10_000.0, 10_000.0), CORRIDOR) is NO_PLAN


def test_a_plan_whose_one_ring_runs_to_and_fro_without_end_has_no_walls() -> None:
    ring = [list(reversed(PLACE.to_wgs84(0.2 + 0.01 * (k % 7), 9_000.0 * (k % 2)))) for k in range(5000)]
    geometry = {"type": "Polygon", "coordinates": [[*ring, ring[0]]]}
    plan = {"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {}, "geometry": geometry}]}
    assert free_space(plan, PLACE, (0.5, 10_000.0), CORRIDOR) is NO_PLAN


def test_thousands_of_ordinary_rooms_are_walls() -> None:
    rooms = [(4.0 * i + 1.0, 4.0 * j + 10.0, 4.0 * i + 4.0, 4.0 * j + 13.0) for i in range(50) for j in range(40)]
    space = free_space(drawn((0.0, 0.0, 202.0, 180.0), *rooms), PLACE, (202.0, 180.0), CORRIDOR)
    assert at(space, 100.5, 100.5) and not at(space, 102.5, 99.5)
