from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.floorplan.georeference import METRES_PER_DEGREE, Georeference

PLACES = st.builds(Georeference, st.floats(-80.0, 80.0), st.floats(-179.0, 179.0), st.floats(-math.pi, math.pi))
METRES = st.floats(-500.0, 500.0)


@given(PLACES, METRES, METRES)
def test_there_and_back_is_the_same_point(place: Georeference, x_m: float, y_m: float) -> None:
    assert place.to_local(*place.to_wgs84(x_m, y_m)) == pytest.approx((x_m, y_m), abs=1e-5)


@given(PLACES, METRES, METRES)
def test_distances_are_kept(place: Georeference, x_m: float, y_m: float) -> None:
    latitude, longitude = place.to_wgs84(x_m, y_m)
    north_m = (latitude - place.latitude_deg) * METRES_PER_DEGREE
    east_m = (longitude - place.longitude_deg) * METRES_PER_DEGREE * math.cos(math.radians(place.latitude_deg))
    assert math.hypot(east_m, north_m) == pytest.approx(math.hypot(x_m, y_m), abs=1e-5)


def test_without_rotation_y_is_north_and_x_east() -> None:
    place = Georeference(60.0, 10.0, 0.0)
    assert place.to_wgs84(0.0, METRES_PER_DEGREE) == pytest.approx((61.0, 10.0))
    assert place.to_wgs84(METRES_PER_DEGREE, 0.0) == pytest.approx((60.0, 12.0))


def test_a_quarter_turn_clockwise_points_the_y_axis_east() -> None:
    latitude, longitude = Georeference(0.0, 0.0, math.pi / 2).to_wgs84(0.0, METRES_PER_DEGREE)
    assert (latitude, longitude) == pytest.approx((0.0, 1.0))
