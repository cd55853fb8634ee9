"""One scan, one place; and which of its readings count."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.evaluation.recordings import floor_folders, is_test_walk, read_walk
from app.observations import WifiScan
from app.wifi.beacons import parted
from app.wifi.locate import locate_scan
from app.wifi.radio_map import build_radio_map
from app.wifi.readings import at_least, fresh_readings, strongest
from tests.open_data import open_data
from tests.wifi.surveys import corridor, heard_at


@st.composite
def scans(draw: st.DrawFn) -> WifiScan:
    readings = draw(st.lists(st.tuples(st.integers(-100, -20), st.floats(0.0, 30.0)), max_size=20))
    rssi, age = [one for one, _ in readings], [one for _, one in readings]
    return WifiScan(100.0, np.arange(len(rssi)), np.array(rssi, dtype=np.float64), 100.0 - np.array(age))


@given(scan=scans(), max_age_s=st.floats(0.0, 30.0))
def test_fresh_readings_are_those_seen_lately(scan: WifiScan, max_age_s: float) -> None:
    fresh = fresh_readings(scan, max_age_s)
    expected = [i for i in range(len(scan.bssid)) if scan.seen_s[i] >= scan.time_s - max_age_s]
    assert fresh.bssid.tolist() == expected
    assert fresh.rssi_dbm.tolist() == scan.rssi_dbm[expected].tolist()
    assert fresh.seen_s.tolist() == scan.seen_s[expected].tolist()


@given(scan=scans(), count=st.integers(1, 25))
def test_the_strongest_are_no_weaker_than_the_rest(scan: WifiScan, count: int) -> None:
    kept = strongest(scan, count).rssi_dbm.tolist()
    assert kept == sorted(scan.rssi_dbm.tolist(), reverse=True)[:count]


@given(scan=scans(), threshold_dbm=st.floats(-110, -10))
def test_a_threshold_keeps_what_reaches_it(scan: WifiScan, threshold_dbm: float) -> None:
    assert at_least(scan, threshold_dbm).rssi_dbm.tolist() == [r for r in scan.rssi_dbm.tolist() if r >= threshold_dbm]


def test_a_scan_is_placed_on_its_floor() -> None:
    radio_map = build_radio_map(corridor())
    located = locate_scan(radio_map, heard_at(20.0, 0, np.random.default_rng(4)))
    assert located is not None
    assert located.position.floor == "B1"
    assert abs(located.position.x_m - 20.0) < 4.0
    assert located.accuracy_m > 0.0


def test_stale_readings_do_not_place_a_scan() -> None:
    scan = heard_at(20.0, 0, np.random.default_rng(4))
    stale = WifiScan(scan.time_s, scan.bssid, scan.rssi_dbm, scan.seen_s - 60.0)
    assert locate_scan(build_radio_map(corridor()), stale) is None


def test_a_map_knows_the_access_points_it_was_made_from() -> None:
    survey = corridor()
    assert set(build_radio_map(survey).bssid.tolist()) == {i for one in survey for i in one.bssid.tolist()}


def test_the_true_place_of_recorded_scans_is_mostly_within_the_accuracy() -> None:
    folders = floor_folders(open_data("mall"))
    read = [read_walk(folder.floor.floor, path) for folder in folders for path in folder.traces[::4]]
    walks = [walk for walk in read if walk is not None]
    survey = [walk for walk in walks if not is_test_walk(walk.trace.trace, 5, 1)]
    radio_map = build_radio_map(parted([one for walk in survey for one in walk.fingerprints])[0])
    test = [walk for walk in walks if is_test_walk(walk.trace.trace, 5, 1)]
    walked = parted([one for walk in test for one in walk.fingerprints])[0]
    inside = []
    for one in walked:
        located = locate_scan(radio_map, WifiScan(0.0, one.bssid, one.rssi_dbm, np.zeros(len(one.bssid))))
        assert located is not None
        apart_m = math.hypot(located.position.x_m - one.x_m, located.position.y_m - one.y_m)
        inside.append(located.position.floor == one.floor and apart_m <= located.accuracy_m)
    assert len(inside) > 100
    assert 0.5 < np.mean(inside) < 0.85
