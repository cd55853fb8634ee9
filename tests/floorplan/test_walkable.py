from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.estimation.arrays import BoolArray, FloatArray
from app.floorplan.georeference import Georeference
from app.floorplan.walkable import drawing_work, least_work, plan_polygons, walkable_cells

PLACE = Georeference(30.0, 120.0, 0.3)
NOWHERE = np.empty((0, 2))


def ring(*corners: tuple[float, float]) -> list[list[float]]:
    """A closed ring in WGS 84 of corners in the floor's frame."""
    positions = [PLACE.to_wgs84(x, y) for x, y in corners]
    return [[longitude, latitude] for latitude, longitude in [*positions, positions[0]]]


def square(west: float, south: float, east: float, north: float) -> list[list[float]]:
    return ring((west, south), (east, south), (east, north), (west, north))


def plan(*geometries: dict[str, Any] | None) -> dict[str, Any]:
    return {"features": [{"type": "Feature", "properties": {}, "geometry": one} for one in geometries]}


def polygon(*rings: list[list[float]]) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": list(rings)}


def cells(*geometries: dict[str, Any] | None, visited: FloatArray = NOWHERE) -> BoolArray:
    return walkable_cells(plan_polygons(plan(*geometries), PLACE), visited, (20.0, 10.0), 1.0)


def test_without_a_plan_everything_within_the_frame_counts() -> None:
    assert walkable_cells([], NOWHERE, (20.5, 10.0), 1.0).shape == (10, 21)
    assert walkable_cells([], NOWHERE, (20.5, 10.0), 1.0).all()


def test_what_counts_is_within_the_outline_and_not_in_rooms() -> None:
    found = cells(polygon(square(2, 1, 18, 9)), polygon(square(4, 3, 8, 6)), polygon(square(10, 3, 12, 9)))
    expected = np.zeros((10, 20), bool)
    expected[1:9, 2:18] = True
    expected[3:6, 4:8] = expected[3:9, 10:12] = False
    np.testing.assert_array_equal(found, expected)


def test_a_room_that_somebody_has_been_in_counts() -> None:
    rooms = polygon(square(0, 0, 20, 10)), polygon(square(4, 3, 8, 6)), polygon(square(10, 3, 12, 9))
    found = cells(*rooms, visited=np.array([[5.5, 4.5], [-3.0, 2.0], [500.0, 500.0]]))
    assert found[3:6, 4:8].all() and not found[3:9, 10:12].any()


def test_holes_parts_and_collections_are_read_and_what_has_no_area_is_not() -> None:
    outline = {"type": "MultiPolygon", "coordinates": [[square(0, 0, 6, 6), square(2, 2, 4, 4)], [square(8, 0, 12, 4)]]}
    point = {"type": "Point", "coordinates": [120.0, 30.0]}
    room = {"type": "GeometryCollection", "geometries": [point, polygon(square(9, 1, 11, 3))]}
    found = cells(None, point, outline, room)
    assert found.sum() == 36 - 4 + 16 - 4
    assert not found[2:4, 2:4].any() and not found[1:3, 9:11].any() and found[0, 8]


@given(
    st.tuples(*[st.floats(-5.0, 25.0)] * 2),
    st.floats(0.5, 12.0),
    st.lists(st.floats(0.4, 1.0), min_size=3, max_size=9),
)
def test_the_raster_agrees_with_a_point_in_polygon_test(
    centre: tuple[float, float], radius: float, shares: list[float]
) -> None:
    """The winding angle about the cell's centre is another way to tell."""
    angles = [2.0 * math.pi * k / len(shares) for k in range(len(shares))]
    corners = np.array(
        [
            (centre[0] + radius * s * math.cos(a), centre[1] + radius * s * math.sin(a))
            for a, s in zip(angles, shares, strict=True)
        ]
    )
    found = cells(polygon(ring(*map(tuple, corners.tolist()))))
    for row in range(10):
        for column in range(20):
            ray = corners - (column + 0.5, row + 0.5)
            following = np.roll(ray, -1, axis=0)
            cross, dot = ray[:, 0] * following[:, 1] - ray[:, 1] * following[:, 0], (ray * following).sum(axis=1)
            length = np.hypot(*(following - ray).T)
            if (np.abs(cross) < 1e-4 * length).any():
                continue  # on an edge, where rounding decides
            winding = np.arctan2(cross, dot).sum()
            assert found[row, column] == (abs(winding) > math.pi)


def test_an_outline_that_is_nowhere_leaves_nothing() -> None:
    assert not cells(polygon(square(100, 100, 120, 110))).any()


@pytest.mark.parametrize("cell_m", [0.5, 1.0, 2.0])
def test_the_area_does_not_depend_on_the_size_of_the_cells(cell_m: float) -> None:
    features = plan_polygons(plan(polygon(square(2, 2, 18, 8))), PLACE)
    assert walkable_cells(features, NOWHERE, (20.0, 10.0), cell_m).sum() * cell_m**2 == pytest.approx(96.0)


def test_parts_of_a_room_that_lie_beside_the_frame_change_nothing() -> None:
    parts = {"type": "MultiPolygon", "coordinates": [[square(-9, -9, -2, 4)], [square(15, 6, 30, 30)]]}
    found = cells(polygon(square(-5, -5, 25, 15)), parts, polygon(square(40, 40, 50, 50)))
    expected = np.ones((10, 20), bool)
    expected[6:, 15:] = False
    np.testing.assert_array_equal(found, expected)


def test_the_work_of_a_plan_is_that_within_the_frame() -> None:
    def work(*geometries: dict[str, Any]) -> float:
        return drawing_work(plan_polygons(plan(*geometries), PLACE), (20.0, 10.0), 0.1)

    outline = polygon(square(0, 0, 20, 10))
    assert work(polygon(square(-900, -900, 900, 900))) == pytest.approx(work(outline), rel=1e-3)
    assert work(outline, outline, outline) == pytest.approx(3.0 * work(outline), rel=1e-3)
    assert work(outline, polygon(square(5, 5, 6, 6))) < 1.5 * work(outline)
    drawn = plan(outline, {"type": "Point", "coordinates": [120.0, 30.0]}, polygon(square(5, 5, 6, 6)))
    assert 0 < least_work(drawn) == 2 / 3 * least_work(plan(outline, outline, outline)) < work(outline, outline)
