"""WKNN over the strongest access points against the equations written out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.strongest_wknn import StrongestSettings, strongest_wknn
from tests.wifi.surveys import ACCESS_POINTS, corridor, fingerprint, fingerprints, heard_at

SCANS = st.dictionaries(st.integers(1, ACCESS_POINTS), st.integers(-100, -20), min_size=1)
EVERY = 1000


def plain_distances(radio_map: RadioMap, scan: dict[int, int], settings: StrongestSettings) -> list[float]:
    """Eq. 1, root mean square, point by point; infinite where nothing is shared."""
    known = {bssid: rssi for bssid, rssi in scan.items() if bssid in radio_map.bssid.tolist()}
    strongest = sorted(known, key=lambda bssid: (-known[bssid], bssid))[: settings.count]
    found = []
    for point in range(len(radio_map.scans)):
        means = {}
        for at in np.flatnonzero(radio_map.point == point):
            share = float(radio_map.share_heard[at])
            height = max(float(radio_map.mean_dbm[at]) - settings.missing_dbm, 0.0)
            means[int(radio_map.bssid[radio_map.access_point[at]])] = share * height
        apart = [max(known[i] - settings.missing_dbm, 0.0) - means.get(i, 0.0) for i in strongest]
        shares = any(i in means for i in strongest)
        found.append(math.sqrt(sum(d * d for d in apart) / len(apart)) if shares else math.inf)
    return found


def columns(scan: dict[int, int]) -> tuple[np.ndarray, np.ndarray]:
    return np.array(list(scan), np.int64), np.array(list(scan.values()), np.float64)


@given(survey=fingerprints(), scan=SCANS, count=st.integers(1, 14))
def test_neighbours_are_those_of_the_equations(survey: list[Fingerprint], scan: dict[int, int], count: int) -> None:
    radio_map = build_radio_map(survey)
    settings = StrongestSettings(count=count, neighbours=EVERY)
    match = strongest_wknn(radio_map, *columns(scan), settings)
    if not set(scan) & set(radio_map.bssid.tolist()):
        assert match is None
        return
    plain = plain_distances(radio_map, scan, settings)
    if match is None:
        assert all(map(math.isinf, plain))
        return
    assert match.distance == pytest.approx([plain[point] for point in match.points], abs=1e-3)
    on_floor = [p for p in range(len(plain)) if math.isfinite(plain[p]) and radio_map.floor[p] == match.floor]
    assert sorted(match.points.tolist()) == on_floor
    weight = 1.0 / np.maximum(match.distance, 1e-3)
    assert match.xy_m == pytest.approx(weight @ radio_map.xy_m[match.points] / weight.sum())


@given(survey=fingerprints(), scan=SCANS, data=st.data())
def test_among_some_points_the_match_is_that_of_those_points(
    survey: list[Fingerprint], scan: dict[int, int], data: st.DataObject
) -> None:
    radio_map = build_radio_map(survey)
    some = np.array(sorted(data.draw(st.sets(st.integers(0, len(radio_map.scans) - 1), min_size=1))), np.int64)
    settings = StrongestSettings(count=6, neighbours=EVERY)
    match = strongest_wknn(radio_map, *columns(scan), settings, points=some)
    plain = plain_distances(radio_map, scan, settings) if set(scan) & set(radio_map.bssid.tolist()) else []
    shared = [p for p in some if plain and math.isfinite(plain[p])]
    if match is None:
        assert not shared
        return
    assert set(match.points) <= set(shared)
    assert match.distance == pytest.approx([plain[point] for point in match.points], abs=1e-3)


def test_points_looked_up_and_points_walked_past_are_the_same() -> None:
    survey = [fingerprint("F1", float(k), 0.0, {1: -40 - k % 50, 2: -90 + k % 40}, time_s=k) for k in range(400)]
    radio_map = build_radio_map(survey, cell_m=0.0)
    scan = np.array([1, 2]), np.array([-55.0, -75.0])
    settings = StrongestSettings(neighbours=EVERY)
    whole = strongest_wknn(radio_map, *scan, settings)
    assert whole is not None
    distance = dict(zip(whole.points.tolist(), whole.distance.tolist(), strict=True))
    for some in (np.arange(0, 400, 40), np.arange(0, 400, 2)):
        match = strongest_wknn(radio_map, *scan, settings, points=some)
        assert match is not None
        assert sorted(match.points) == some.tolist()
        assert match.distance == pytest.approx([distance[point] for point in match.points])


@given(scan=SCANS, seed=st.integers(0, 1000))
def test_the_order_of_the_readings_does_not_matter(scan: dict[int, int], seed: int) -> None:
    radio_map = build_radio_map(corridor())
    bssid, rssi_dbm = columns(scan)
    order = np.random.default_rng(seed).permutation(len(bssid))
    one = strongest_wknn(radio_map, bssid, rssi_dbm, StrongestSettings(count=3))
    other = strongest_wknn(radio_map, bssid[order], rssi_dbm[order], StrongestSettings(count=3))
    assert (one is None) == (other is None)
    if one is not None and other is not None:
        assert np.array_equal(one.points, other.points) and np.array_equal(one.xy_m, other.xy_m)


def test_weak_readings_beyond_the_strongest_change_nothing() -> None:
    radio_map = build_radio_map(corridor())
    scan = heard_at(13.0, 0, np.random.default_rng(3))
    order = np.argsort(-scan.rssi_dbm)
    kept, settings = order[:4], StrongestSettings(count=4)
    whole = strongest_wknn(radio_map, scan.bssid, scan.rssi_dbm, settings)
    cut = strongest_wknn(radio_map, scan.bssid[kept], scan.rssi_dbm[kept], settings)
    assert whole is not None and cut is not None
    assert np.array_equal(whole.points, cut.points) and np.array_equal(whole.distance, cut.distance)


def test_a_walker_is_placed_near_on_his_floor() -> None:
    radio_map, rng = build_radio_map(corridor()), np.random.default_rng(5)
    for floor in (0, 1):
        for x_m in (5.0, 20.0, 33.0):
            scan = heard_at(x_m, floor, rng)
            match = strongest_wknn(radio_map, scan.bssid, scan.rssi_dbm)
            assert match is not None and match.floor == floor
            assert abs(match.xy_m[0] - x_m) < 4.0
