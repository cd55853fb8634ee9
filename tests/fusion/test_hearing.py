"""A phone that never hears some access points is told from one that is elsewhere."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.hearing import Hearing, HearingSettings, after, match_heard
from app.observations import WifiScan
from app.wifi.fingerprint import Fingerprint
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.signal_distance import NOTHING

SETTINGS = HearingSettings()
PLACES_M = np.arange(10) * 8.0
BSSID = np.arange(1, 41)
"""Four at each place."""


def level_dbm(x_m: float) -> np.ndarray:
    return -40.0 - 1.2 * np.abs(x_m - np.repeat(PLACES_M, 4))


def surveyed() -> RadioMap:
    heard = [(x, level_dbm(x)) for x in np.arange(0.0, 73.0, 2.0)]
    prints = [Fingerprint("F1", float(x), 0.0, 0.0, "walk", BSSID[dbm > -90.0], dbm[dbm > -90.0]) for x, dbm in heard]
    return build_radio_map(prints)


MAP = surveyed()


def scan_at(x_m: float, deaf: np.ndarray = NOTHING) -> WifiScan:
    dbm = level_dbm(x_m)
    heard = (dbm > -90.0) & ~np.isin(BSSID, deaf)
    return WifiScan(0.0, BSSID[heard], dbm[heard], np.zeros(np.count_nonzero(heard)))


def matched(scan: WifiScan, hearing: Hearing, unheeded: np.ndarray = NOTHING) -> Match | None:
    found = match_heard(MAP, scan, hearing, unheeded, 3, SETTINGS)
    return None if found is None else found.match


def test_a_phone_that_hears_everything_is_matched_with_everything() -> None:
    scan = scan_at(30.0)
    match = matched(scan, after(Hearing(), scan, SETTINGS))
    assert match is not None and abs(match.xy_m[0] - 30.0) < 2.0


def test_three_of_four_access_points_may_be_missing_and_the_place_is_found_as_surely() -> None:
    deaf = BSSID[np.arange(40) % 4 > 0]
    scan = scan_at(30.0, deaf)
    match = matched(scan, after(Hearing(), scan, SETTINGS))
    full = matched(scan, Hearing(BSSID))
    assert match is not None and full is not None
    assert abs(match.xy_m[0] - 30.0) < 2.0
    assert match.signal_distance < 0.02 < 0.2 < full.signal_distance


def test_what_the_scan_itself_holds_is_heard_though_more_than_is_remembered() -> None:
    scan = scan_at(30.0, BSSID[np.arange(40) % 4 > 1])
    forgetful = HearingSettings(remembered=2)
    found = match_heard(MAP, scan, after(Hearing(), scan, forgetful), NOTHING, 3, forgetful)
    match = None if found is None else found.match
    remembering = matched(scan, after(Hearing(), scan, SETTINGS))
    assert match is not None and remembering is not None
    assert match.xy_m.tolist() == remembering.xy_m.tolist()
    assert match.signal_distance == remembering.signal_distance


def test_a_scan_unlike_everything_stays_unlike_for_a_phone_that_has_heard_the_rest() -> None:
    odd = WifiScan(0.0, np.array([1, 20, 39]), np.full(3, -45.0), np.zeros(3))
    match = matched(odd, Hearing(BSSID))
    assert match is not None and match.signal_distance > 0.3


def test_a_scan_much_of_which_is_new_to_the_map_stays_strange_though_the_phone_may_be_deaf() -> None:
    scan = scan_at(30.0, BSSID[np.arange(40) % 4 > 0])
    new = np.arange(1000, 1000 + len(scan.bssid))
    faint = np.full(len(new), -85.0)
    mixed = WifiScan(0.0, np.append(scan.bssid, new), np.append(scan.rssi_dbm, faint), np.zeros(2 * len(new)))
    for heard, strange in ((scan, False), (mixed, True)):
        found = match_heard(MAP, heard, after(Hearing(), heard, SETTINGS), NOTHING, 3, SETTINGS)
        assert found is not None
        assert abs(found.match.xy_m[0] - 30.0) < 2.0 and found.match.signal_distance < 0.02
        assert (found.strange.signal_distance > 0.2) == strange == (found.strange.unlike > 0.2)


def test_access_points_that_are_not_relied_on_count_on_neither_side() -> None:
    loudest = BSSID[12:16]
    scan = scan_at(24.0, loudest)
    match = matched(scan, Hearing(BSSID), loudest)
    assert match is not None and abs(match.xy_m[0] - 24.0) < 2.0 and match.signal_distance < 0.05


@pytest.mark.parametrize("deaf", [NOTHING, BSSID[np.arange(40) % 4 > 0]])
def test_a_scan_is_unlike_places_as_much_as_they_are_far_off_whatever_the_phone_hears(deaf: np.ndarray) -> None:
    scan = scan_at(30.0, deaf)
    found = match_heard(MAP, scan, after(Hearing(), scan, SETTINGS), NOTHING, 3, SETTINGS)
    assert found is not None
    less_like = [found.less_like(MAP, np.array([x_m, 0.0]), 3.0) for x_m in (30.0, 40.0, 70.0)]
    assert 0.0 <= less_like[0] < 0.02 < less_like[1] < less_like[2]
    assert found.less_like(MAP, np.array([30.0, 500.0]), 3.0) == math.inf


@given(st.lists(st.lists(st.integers(1, 5000), unique=True, max_size=80), max_size=20))
def test_the_session_remembers_what_it_heard_last_and_no_more_than_so_many(scans: list[list[int]]) -> None:
    hearing = Hearing()
    for heard in scans:
        bssid = np.array(heard, np.int64)
        hearing = after(hearing, WifiScan(0.0, bssid, np.full(len(bssid), -50.0), np.zeros(len(bssid))), SETTINGS)
        assert set(heard) <= set(hearing.bssid.tolist())
    assert len(set(hearing.bssid.tolist())) == len(hearing.bssid) <= SETTINGS.remembered
