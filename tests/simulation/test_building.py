from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.errors import InvalidInput
from app.floorplan.georeference import METRES_PER_DEGREE
from app.simulation.building import make_building
from app.simulation.layouts import LAYOUTS, Rect
from app.simulation.plan_files import PIXELS_PER_METRE, plan_geojson, plan_image

KINDS = st.sampled_from(sorted(LAYOUTS))
SEEDS = st.integers(0, 10_000)


@settings(max_examples=25, deadline=None)
@given(kind=KINDS, seed=SEEDS)
def test_no_route_goes_through_a_wall(kind: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    floor = make_building("x", kind, 1, rng).floors[0]
    route = floor.route(rng, 300.0)
    assert floor.walls.loss_between_db(route[:-1], route[1:]).max() == 0.0


@settings(max_examples=25, deadline=None)
@given(kind=KINDS, seed=SEEDS, length_m=st.floats(5.0, 400.0))
def test_a_route_is_as_long_as_asked_for_and_stays_in_the_frame(kind: str, seed: int, length_m: float) -> None:
    rng = np.random.default_rng(seed)
    floor = make_building("x", kind, 1, rng).floors[0]
    route = floor.route(rng, length_m)
    assert np.linalg.norm(np.diff(route, axis=0), axis=1).sum() == pytest.approx(length_m, abs=0.5)
    assert (route >= 0.0).all()
    assert (route <= [floor.width_m, floor.height_m]).all()


@settings(max_examples=15, deadline=None)
@given(kind=KINDS, seed=SEEDS)
def test_the_frame_is_laid_out_by_the_first_feature_as_in_the_open_data(kind: str, seed: int) -> None:
    building = make_building("x", kind, 2, np.random.default_rng(seed))
    for floor in building.floors:
        ring = np.array(plan_geojson(building, floor)["features"][0]["geometry"]["coordinates"][0])
        west, south = ring.min(axis=0)
        east, north = ring.max(axis=0)
        assert (south, west) == pytest.approx(
            (building.georeference.latitude_deg, building.georeference.longitude_deg), abs=1e-9
        )
        assert (east - west) * METRES_PER_DEGREE * math.cos(math.radians(south)) == pytest.approx(
            floor.width_m, abs=0.01
        )
        assert (north - south) * METRES_PER_DEGREE == pytest.approx(floor.height_m, abs=0.01)


def test_the_outline_is_closed_by_outer_walls() -> None:
    for kind in LAYOUTS:
        floor = make_building("x", kind, 1, np.random.default_rng(1)).floors[0]
        centre = floor.to_frame(np.array([floor.layout.corridors[0].centre]))
        around = centre + 1000.0 * np.array([(math.cos(a), math.sin(a)) for a in np.linspace(0.01, 6.2, 97)])
        assert floor.walls.loss_between_db(np.repeat(centre, 97, axis=0), around).min() > 7.0


def test_the_picture_spans_the_frame() -> None:
    floor = make_building("x", "hospital", 1, np.random.default_rng(1)).floors[0]
    picture = plan_image(floor)
    assert picture.startswith(b"\x89PNG")
    assert int.from_bytes(picture[16:20], "big") == round(floor.width_m * PIXELS_PER_METRE)


@pytest.mark.parametrize(("kind", "floors"), [("castle", 1), ("office", 0), ("office", 41)])
def test_a_building_that_is_not_known_is_refused_by_name(kind: str, floors: int) -> None:
    with pytest.raises(InvalidInput) as refusal:
        make_building("x", kind, floors, np.random.default_rng(1))
    assert refusal.value.field in ("building", "floors")


@given(edge=st.tuples(*[st.floats(-100.0, 100.0)] * 4), margin_m=st.floats(0.0, 300.0))
def test_a_rectangle_that_is_too_narrow_shrinks_to_its_centre_line_and_no_further(
    edge: tuple[float, float, float, float], margin_m: float
) -> None:
    (x0, x1), (y0, y1) = sorted(edge[:2]), sorted(edge[2:])
    found = Rect(x0, y0, x1, y1).shrunk(margin_m)
    assert x0 <= found.x0 <= found.x1 <= x1
    assert y0 <= found.y0 <= found.y1 <= y1
