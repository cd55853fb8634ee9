"""Matching on the move: which readings and which reference points count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.observations import WifiScan
from app.wifi.moving_signals import PLAIN, SignalSettings, candidates_of, loud_readings, match_among, on_floor
from app.wifi.radio_map import build_radio_map
from tests.wifi.surveys import corridor, fingerprint

PAPER = SignalSettings(least_readings=1)
CORRIDOR = build_radio_map(corridor())


def scan(heard: dict[int, float]) -> WifiScan:
    return WifiScan(1.0, np.array(list(heard)), np.array(list(heard.values())), np.full(len(heard), 1.0))


def test_a_moving_phone_loses_more_of_its_weak_readings_than_one_that_is_still() -> None:
    heard = scan({1: -60.0, 2: -75.0, 3: -80.0, 4: -85.0, 5: -86.0})
    assert loud_readings(heard, False, PAPER).bssid.tolist() == [1, 2]
    assert loud_readings(heard, True, PAPER).bssid.tolist() == [1, 2, 3, 4]
    assert loud_readings(heard, False, PLAIN).bssid.tolist() == [1, 2, 3, 4, 5]


def test_a_scan_that_is_weak_throughout_keeps_its_strongest() -> None:
    heard = scan({1: -90.0, 2: -80.0, 3: -85.0})
    assert loud_readings(heard, False, replace(PAPER, least_readings=2)).bssid.tolist() == [2, 3]


def test_candidates_are_those_whose_two_strongest_hold_the_scans_strongest() -> None:
    radio_map = build_radio_map(
        [fingerprint("F1", 10.0 * k, 0.0, {k: -40, k + 1: -50, k + 2: -60}) for k in range(1, 6)]
    )
    points = candidates_of(radio_map, scan({3: -50.0, 1: -70.0}), PAPER)
    assert points is not None and radio_map.xy_m[points, 0].tolist() == [20.0, 30.0]
    match = match_among(radio_map, scan({3: -50.0, 1: -70.0}), points, PAPER)
    assert match is not None and set(match.points) <= set(points)


def test_without_candidates_every_reference_point_is_one() -> None:
    radio_map = build_radio_map([fingerprint("F1", 10.0 * k, 0.0, {k: -40, k + 1: -50, 9: -80}) for k in range(1, 6)])
    heard = scan({9: -50.0})
    assert candidates_of(radio_map, heard, PAPER) is None
    assert match_among(radio_map, heard, None, PAPER) is not None


def test_candidates_of_one_floor_give_way_on_another() -> None:
    low = fingerprint("F1", 0.0, 0.0, {1: -40, 2: -50, 3: -60})
    high = fingerprint("F2", 5.0, 5.0, {2: -40, 3: -50, 1: -60})
    radio_map, heard = build_radio_map([low, high]), scan({1: -45.0, 2: -55.0, 3: -65.0})
    points = candidates_of(radio_map, heard, PAPER)
    assert points is not None and radio_map.floor[points].tolist() == [0]
    match = match_among(radio_map, heard, points, PAPER, floor=1)
    assert match is not None and match.floor == 1


def test_the_points_of_a_floor_are_counted_out() -> None:
    some = np.arange(0, len(CORRIDOR.floor), 3)
    assert set(CORRIDOR.floor[on_floor(CORRIDOR, None, 1)]) == {1}
    assert on_floor(CORRIDOR, some, 1).tolist() == [p for p in some if CORRIDOR.floor[p] == 1]
