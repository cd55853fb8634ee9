"""Which reference points a matcher looks at: AP match and moving partition."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.ap_match import ap_match_candidates
from app.wifi.fingerprint import Fingerprint
from app.wifi.moving_partition import partition_around
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.representation import represent
from tests.wifi.surveys import ACCESS_POINTS, corridor, fingerprint, fingerprints

PLACES = st.tuples(st.floats(-3.0, 12.0), st.floats(-3.0, 12.0))


def two_strongest(radio_map: RadioMap, point: int) -> set[int]:
    value = represent(radio_map.mean_dbm) * radio_map.share_heard
    own = np.flatnonzero(radio_map.point == point)
    ranked = sorted(own.tolist(), key=lambda pair: (-value[pair], radio_map.access_point[pair]))
    return {int(radio_map.bssid[radio_map.access_point[pair]]) for pair in ranked[:2]}


@given(survey=fingerprints(), loudest=st.integers(1, ACCESS_POINTS))
def test_candidates_have_the_scans_strongest_among_their_two_strongest(survey: list[Fingerprint], loudest: int) -> None:
    radio_map = build_radio_map(survey)
    scan = np.array([loudest, 999]), np.array([-40.0, -30.0])
    expected = [p for p in range(len(radio_map.scans)) if loudest in two_strongest(radio_map, p)]
    assert ap_match_candidates(radio_map, *scan).tolist() == expected


def test_a_scan_of_unknown_access_points_has_no_candidates() -> None:
    unknown = np.array([9999]), np.array([-40.0])
    assert len(ap_match_candidates(build_radio_map(corridor()), *unknown)) == 0
    assert len(ap_match_candidates(build_radio_map([]), *unknown)) == 0


def test_the_strongest_counts_whatever_its_place_in_the_scan() -> None:
    radio_map = build_radio_map([fingerprint("F1", 10.0 * i, 0.0, {i: -40, i + 10: -50}) for i in range(1, 4)])
    bssid, rssi_dbm = np.array([3, 2, 1]), np.array([-60.0, -45.0, -70.0])
    found = ap_match_candidates(radio_map, bssid, rssi_dbm)
    assert radio_map.xy_m[found].tolist() == [[20.0, 0.0]]


@given(survey=fingerprints(least=0), place=PLACES, radius_m=st.floats(0.1, 8.0))
def test_a_partition_holds_all_points_within_its_radius(
    survey: list[Fingerprint], place: tuple[float, float], radius_m: float
) -> None:
    radio_map = build_radio_map(survey)
    for floor in range(len(radio_map.floors)):
        apart_m = np.hypot(radio_map.xy_m[:, 0] - place[0], radio_map.xy_m[:, 1] - place[1])
        expected = np.flatnonzero((apart_m <= radius_m) & (radio_map.floor == floor))
        assert partition_around(radio_map, floor, *place, radius_m).points.tolist() == expected.tolist()
