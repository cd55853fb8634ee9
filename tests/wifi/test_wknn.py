"""Weighted nearest neighbours against the distances written out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.fingerprint import Fingerprint
from app.wifi.match_index import index_of
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.representation import Representation, Shape, represent
from app.wifi.signal_distance import Distance, distances
from app.wifi.wknn import WknnSettings, wknn
from tests.wifi.surveys import ACCESS_POINTS, corridor, fingerprints, heard_at

SCANS = st.dictionaries(st.integers(1, ACCESS_POINTS), st.integers(-100, -20), min_size=1)
SHAPES = [Representation(shape) for shape in Shape]


def plain_value(rssi: float, shape: Shape) -> float:
    positive = rssi + 105.0
    match shape:
        case Shape.EXPONENTIAL:
            return math.exp(positive / 24.0) / math.exp(105.0 / 24.0)
        case Shape.POWED:
            return math.pow(positive / 105.0, math.e)
        case _:
            return positive


def plain_rows(radio_map: RadioMap, shape: Shape) -> list[dict[int, float]]:
    rows: list[dict[int, float]] = [{} for _ in radio_map.scans]
    for at, (point, access_point) in enumerate(zip(radio_map.point, radio_map.access_point, strict=True)):
        share = radio_map.count[at] / radio_map.scans[point]
        rows[point][int(radio_map.bssid[access_point])] = share * plain_value(float(radio_map.mean_dbm[at]), shape)
    return rows


def plain_distance(a: dict[int, float], b: dict[int, float], distance: Distance) -> float:
    heard = set(a) | set(b)
    left, right = [a.get(i, 0.0) for i in heard], [b.get(i, 0.0) for i in heard]
    match distance:
        case Distance.EUCLIDEAN:
            return math.dist(left, right)
        case Distance.SORENSEN:
            whole = sum(left) + sum(right)
            return sum(abs(x - y) for x, y in zip(left, right, strict=True)) / whole if whole else 1.0
        case _:
            norms = math.hypot(*left) * math.hypot(*right)
            return 1.0 - sum(x * y for x, y in zip(left, right, strict=True)) / norms if norms else 1.0


@pytest.mark.parametrize("representation", SHAPES, ids=[shape.value for shape in Shape])
@given(rssi=st.integers(-104, 0))
def test_representations_are_those_of_the_paper(representation: Representation, rssi: int) -> None:
    found = float(represent(np.array([rssi]), representation)[0])
    assert found == pytest.approx(plain_value(rssi, representation.shape), rel=1e-5)


@pytest.mark.parametrize("rssi", [-105.0, -110.0, -127.0])
@pytest.mark.parametrize("shape", [Shape.POSITIVE, Shape.EXPONENTIAL, Shape.POWED])
def test_what_is_too_weak_is_not_heard(shape: Shape, rssi: float) -> None:
    assert represent(np.array([rssi]), Representation(shape)).tolist() == [0.0]


@pytest.mark.parametrize("shape", list(Shape))
def test_impossibly_strong_readings_are_clipped(shape: Shape) -> None:
    values = represent(np.array([0.0, 7.0, 20.0]), Representation(shape))
    assert values[0] == values[1] == values[2] == pytest.approx(plain_value(0.0, shape), rel=1e-5)


@pytest.mark.parametrize("distance", list(Distance))
@pytest.mark.parametrize("representation", SHAPES, ids=[shape.value for shape in Shape])
@given(survey=fingerprints(), scan=SCANS)
def test_distances_are_those_of_the_formulas(
    representation: Representation, distance: Distance, survey: list[Fingerprint], scan: dict[int, int]
) -> None:
    radio_map = build_radio_map(survey)
    bssid, rssi_dbm = np.array(list(scan)), np.array(list(scan.values()), dtype=np.float64)
    known = set(radio_map.bssid.tolist())
    query = {i: plain_value(rssi, representation.shape) for i, rssi in scan.items() if i in known}
    expected = [plain_distance(query, row, distance) for row in plain_rows(radio_map, representation.shape)]
    index = index_of(radio_map, representation)
    found = distances(index, bssid, rssi_dbm, distance)
    # a distance of nearly nothing is what rounding leaves of two large squares
    assert found == pytest.approx(expected, rel=1e-4, abs=0.05 if distance is Distance.EUCLIDEAN else 1e-5)
    some = np.arange(len(found))[::-2].copy()
    assert distances(index, bssid, rssi_dbm, distance, some) == pytest.approx(found[some], rel=1e-9, abs=1e-9)


@given(survey=fingerprints(), scan=SCANS, count=st.integers(1, 5))
def test_the_place_is_the_mean_of_the_nearest_on_the_floor_they_vote_for(
    survey: list[Fingerprint], scan: dict[int, int], count: int
) -> None:
    radio_map = build_radio_map(survey)
    settings = WknnSettings(distance=Distance.SORENSEN, neighbours=count)
    bssid, rssi_dbm = np.array(list(scan)), np.array(list(scan.values()), dtype=np.float64)
    match = wknn(radio_map, bssid, rssi_dbm, settings)
    distance = distances(index_of(radio_map), bssid, rssi_dbm, Distance.SORENSEN)
    sharing = [point for point in range(len(distance)) if distance[point] < 1.0]
    if not sharing:
        assert match is None
        return
    assert match is not None
    nearest = sorted(sharing, key=lambda point: distance[point])[:count]
    votes = np.zeros(len(radio_map.floors))
    for point in nearest:
        votes[radio_map.floor[point]] += 1.0 / max(distance[point], 1e-6)
    assert match.floor_probability == pytest.approx(votes / votes.sum())
    on_floor = [point for point in sharing if radio_map.floor[point] == votes.argmax()]
    chosen = sorted(on_floor, key=lambda point: distance[point])[:count]
    weight = np.array([1.0 / max(distance[point], 1e-6) for point in chosen])
    place = np.average(radio_map.xy_m[chosen], axis=0, weights=weight)
    assert match.floor == votes.argmax()
    assert match.points.tolist() == chosen
    assert match.xy_m == pytest.approx(place)
    scatter = np.cov(radio_map.xy_m[chosen].T, aweights=weight, ddof=0) if len(chosen) > 1 else np.zeros((2, 2))
    assert match.covariance_m2 == pytest.approx(scatter, abs=1e-9)
    assert match.signal_distance == pytest.approx(distance[chosen[0]])


def test_a_phone_that_reads_low_is_placed_the_same() -> None:
    radio_map = build_radio_map(corridor())
    rng = np.random.default_rng(2)
    shifts_m = []
    for x_m in rng.uniform(2.0, 38.0, 30):
        scan = heard_at(float(x_m), 1, rng)
        true, low = (wknn(radio_map, scan.bssid, scan.rssi_dbm - offset_db) for offset_db in (0.0, 8.0))
        assert true is not None
        assert low is not None
        shifts_m.append(abs(true.xy_m[0] - low.xy_m[0]))
    assert np.mean(shifts_m) < 1.0


def test_a_floor_that_is_given_is_kept_and_candidates_are_the_only_neighbours() -> None:
    radio_map = build_radio_map(corridor())
    scan = heard_at(20.0, 1, np.random.default_rng(1))
    below = wknn(radio_map, scan.bssid, scan.rssi_dbm, floor=0)
    few = wknn(radio_map, scan.bssid, scan.rssi_dbm, points=np.array([3, 25, 30]))
    assert below is not None
    assert few is not None
    assert below.floor == 0
    assert below.floor_probability[1] > 0.9
    assert set(few.points.tolist()) <= {3, 25, 30}


def test_nothing_known_gives_no_match() -> None:
    heard = np.array([9999]), np.array([-50.0])
    assert wknn(build_radio_map(corridor()), *heard) is None
    assert wknn(build_radio_map([]), *heard) is None
    assert wknn(build_radio_map(corridor()), np.empty(0, np.int64), np.empty(0)) is None
    scan = heard_at(20.0, 1, np.random.default_rng(1))
    assert wknn(build_radio_map(corridor()), scan.bssid, scan.rssi_dbm, points=np.empty(0, np.int64)) is None
