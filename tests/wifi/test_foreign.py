"""Access points that are heard where nobody heard them do not carry a scan off."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.foreign import FOREIGN, Explained, explained, foreign
from app.wifi.left_out import WIFI_MATCH
from app.wifi.match import Match
from app.wifi.match_index import index_of
from app.wifi.signal_distance import NOTHING
from app.wifi.soft_match import soft_match
from tests.wifi.corridor import ACCESS_POINTS, AT_M, MAP, heard, mixed


def told(bssid: np.ndarray, rssi_dbm: np.ndarray) -> tuple[Match, Explained | None]:
    order = np.argsort(bssid)
    bssid, rssi_dbm = bssid[order], rssi_dbm[order]
    match = soft_match(MAP, bssid, rssi_dbm, WIFI_MATCH)
    assert match is not None
    return match, explained(MAP, bssid, rssi_dbm, match, WIFI_MATCH, None, NOTHING)


@given(st.floats(30.0, 170.0))
def test_a_sound_scan_is_left_as_it_is(x_m: float) -> None:
    match, found = told(*heard(x_m, seed=2))
    assert found is not None and found.match is match
    assert found.kept.all() and len(found.foreign) == 0 and found.otherwise_m is None


@given(st.floats(30.0, 80.0), st.integers(8, 16))
def test_loud_access_points_of_elsewhere_are_left_out_by_name_and_the_rest_is_matched(x_m: float, count: int) -> None:
    bssid, rssi_dbm = mixed(x_m, 150.0, count)
    carried_off, found = told(bssid, rssi_dbm)
    assert carried_off.xy_m[0] > 120.0
    assert found is not None and abs(float(found.match.xy_m[0]) - x_m) < 4.0
    assert set(found.foreign.tolist()) == set(bssid[-count:].tolist())


def test_many_that_belong_together_elsewhere_leave_that_place_open() -> None:
    few, many = told(*mixed(50.0, 150.0, 8))[1], told(*mixed(50.0, 150.0, 16))[1]
    assert few is not None and few.otherwise_m is None
    assert many is not None and many.otherwise_m is not None and abs(float(many.otherwise_m[0]) - 150.0) < 6.0


def test_what_must_not_be_relied_on_says_nothing_of_where_foreign_ones_are_at_home() -> None:
    bssid, rssi_dbm = mixed(50.0, 150.0, 16)
    order = np.argsort(bssid)
    bssid, rssi_dbm = bssid[order], rssi_dbm[order]
    unheeded = np.setdiff1d(ACCESS_POINTS[np.abs(AT_M - 150.0) < 40.0], bssid)
    assert len(unheeded) > 20
    plain, wary = (
        explained(MAP, bssid, rssi_dbm, match, WIFI_MATCH, None, out)
        for out in (NOTHING, unheeded)
        for match in [soft_match(MAP, bssid, rssi_dbm, WIFI_MATCH, unheeded=out)]
        if match is not None
    )
    assert plain is not None and wary is not None
    without = soft_match(
        MAP, plain.foreign, rssi_dbm[~plain.kept], WIFI_MATCH, 0, unheeded=np.union1d(unheeded, bssid[plain.kept])
    )
    assert without is not None and wary.otherwise_m is not None
    assert wary.otherwise_m == pytest.approx(without.xy_m)


def test_a_scan_that_is_half_of_one_place_and_half_of_another_says_nothing() -> None:
    assert told(*mixed(50.0, 150.0, 40, loud_db=0.0))[1] is None


def test_a_few_foreign_ones_are_chance() -> None:
    match, found = told(*mixed(50.0, 150.0, FOREIGN.least - 1, loud_db=0.0))
    assert found is not None and found.match is match and len(found.foreign) == 0


@pytest.mark.parametrize("unknown", [[], [1 << 40, (1 << 40) + 1]])
def test_foreign_is_what_the_map_knows_from_elsewhere_only(unknown: list[int]) -> None:
    index = index_of(MAP, WIFI_MATCH.representation, WIFI_MATCH.smooth_m)
    bssid = np.array([ACCESS_POINTS[AT_M == 50.0][0], ACCESS_POINTS[AT_M == 180.0][0], *unknown], np.int64)
    alien = foreign(index, bssid, 0, np.array([50.0, 0.0]), FOREIGN.around_m)
    assert alien.tolist() == [False, True] + [False] * len(unknown)
