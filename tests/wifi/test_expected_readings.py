from __future__ import annotations

import numpy as np
import pytest

from app.wifi.expected_readings import expected_readings
from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import build_radio_map


def _scan(x_m: float, *heard: tuple[int, float], floor: str = "F1") -> Fingerprint:
    bssid, rssi_dbm = zip(*heard, strict=True)
    return Fingerprint(floor, x_m, 0.0, 0.0, "survey", np.array(bssid), np.array(rssi_dbm, np.float64))


SURVEY = (_scan(0.0, (1, -50.0), (2, -80.0)), _scan(3.0, (1, -60.0)), _scan(60.0, (3, -40.0)))
MAP = build_radio_map(SURVEY, cell_m=0.0)


def test_the_scans_around_count_by_a_gaussian_of_their_distance() -> None:
    around = expected_readings(MAP, 0, np.array([0.0, 0.0]), 3.0)
    weight = np.exp(-0.5)
    assert around.scans == pytest.approx(1.0 + weight)
    assert around.heard.tolist() == pytest.approx([1.0 + weight, 1.0, 0.0])
    mean_dbm = (-50.0 - 60.0 * weight) / (1.0 + weight)
    assert around.mean_dbm.tolist() == pytest.approx([mean_dbm, -80.0, 0.0])
    assert around.spread_db[0] == pytest.approx(10.0 * np.sqrt(weight) / (1.0 + weight), abs=1e-3)
    assert around.spread_db[1] == pytest.approx(0.0, abs=1e-3)


def test_what_is_far_away_or_on_another_floor_does_not_count() -> None:
    storeys = build_radio_map((*SURVEY, _scan(0.0, (9, -30.0), floor="F2")), cell_m=0.0)
    upstairs = expected_readings(storeys, 1, np.array([0.0, 0.0]), 3.0)
    assert storeys.bssid[upstairs.heard > 0.0].tolist() == [9]
    nowhere = expected_readings(storeys, 0, np.array([30.0, 0.0]), 3.0)
    assert nowhere.scans == 0.0 and not nowhere.heard.any()


def test_the_spread_is_that_of_the_readings_too_and_not_of_the_places_alone() -> None:
    same = build_radio_map([_scan(0.0, (1, -50.0)), _scan(0.0, (1, -60.0))])
    around = expected_readings(same, 0, np.array([0.0, 0.0]), 3.0)
    assert around.scans == 2.0
    assert around.spread_db[0] == pytest.approx(np.sqrt(50.0), abs=1e-3)
