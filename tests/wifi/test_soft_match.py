"""Soft matching against the formulas written out, and what smoothing does to a map."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given

from app.wifi.fingerprint import Fingerprint
from app.wifi.match_index import index_of
from app.wifi.radio_map import build_radio_map
from app.wifi.representation import SQUARED
from app.wifi.soft_match import SoftSettings, soft_match
from tests.wifi.surveys import corridor, fingerprint, fingerprints, heard_at

SMOOTH_M = 3.0


def plain_smoothed(survey: list[Fingerprint]) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Values of every point and access point: Gaussian means of the points of a floor, up to three deviations away."""
    radio_map = build_radio_map(survey)
    raw = np.zeros((len(radio_map.scans), len(radio_map.bssid)))
    for at, (point, column) in enumerate(zip(radio_map.point, radio_map.access_point, strict=True)):
        share = radio_map.count[at] / radio_map.scans[point]
        raw[point, column] = share * max((radio_map.mean_dbm[at] + 105.0) / 105.0, 0.0) ** 2
    smooth = np.zeros_like(raw)
    for p in range(len(raw)):
        weights = np.zeros(len(raw))
        for q in range(len(raw)):
            apart_m = math.dist(radio_map.xy_m[p], radio_map.xy_m[q])
            if radio_map.floor[p] == radio_map.floor[q] and apart_m <= 3.0 * SMOOTH_M:
                weights[q] = math.exp(-0.5 * (apart_m / SMOOTH_M) ** 2) * radio_map.scans[q]
        smooth[p] = weights @ raw / weights.sum()
    smooth[smooth < 0.003] = 0.0
    return smooth


@given(survey=fingerprints(least=2))
def test_a_smoothed_map_holds_the_mean_of_what_is_around_each_point(survey: list[Fingerprint]) -> None:
    index = index_of(build_radio_map(survey), SQUARED, SMOOTH_M)
    found = np.zeros((len(index.xy_m), len(index.bssid)))
    for column in range(len(index.bssid)):
        pairs = slice(index.start[column], index.start[column + 1])
        found[index.point[pairs], column] = index.value[pairs]
    expected = plain_smoothed(survey)
    near_cut = np.abs(expected - 0.003) < 1e-6
    np.testing.assert_allclose(np.where(near_cut, 0.0, found), np.where(near_cut, 0.0, expected), atol=1e-6)


def test_a_scan_lies_at_the_mean_of_all_points_weighted_by_the_exponential_of_their_distance() -> None:
    survey = corridor(floors=("F1",))
    radio_map, scan = build_radio_map(survey), heard_at(13.0, 0, np.random.default_rng(3))
    smooth = plain_smoothed(survey)
    value = np.zeros(smooth.shape[1])
    for bssid, rssi_dbm in zip(scan.bssid, scan.rssi_dbm, strict=True):
        value[np.searchsorted(radio_map.bssid, bssid)] = max((rssi_dbm + 105.0) / 105.0, 0.0) ** 2
    distance = 1.0 - smooth @ value / (np.linalg.norm(smooth, axis=1) * np.linalg.norm(value))
    weight = np.exp(-(distance - distance.min()) / SoftSettings().softness)
    weight /= weight.sum()
    match = soft_match(radio_map, scan.bssid, scan.rssi_dbm)
    assert match is not None
    np.testing.assert_allclose(match.xy_m, weight @ radio_map.xy_m, atol=1e-3)
    assert match.signal_distance == pytest.approx(distance.min(), abs=1e-5)
    assert abs(match.xy_m[0] - 13.0) < 4.0


def test_a_scan_that_two_places_resemble_is_spread_over_both() -> None:
    alike = {1: -50, 2: -60}
    survey = [fingerprint("F1", x_m, 0.0, alike) for x_m in (0.0, 40.0)] + [fingerprint("F1", 20.0, 0.0, {3: -40})]
    match = soft_match(build_radio_map(survey), np.array([1, 2]), np.array([-50.0, -60.0]))
    assert match is not None
    np.testing.assert_allclose(match.xy_m, [20.0, 0.0], atol=1e-6)
    assert match.covariance_m2[0, 0] == pytest.approx(400.0, rel=1e-3)


def test_a_scan_of_unknown_access_points_has_no_place() -> None:
    radio_map = build_radio_map(corridor())
    assert soft_match(radio_map, np.array([999]), np.array([-50.0])) is None
    assert soft_match(build_radio_map([]), np.array([1]), np.array([-50.0])) is None


def test_the_floor_is_the_one_asked_for_or_else_the_one_the_nearest_vote_for() -> None:
    radio_map, scan = build_radio_map(corridor()), heard_at(10.0, 1, np.random.default_rng(0))
    free = soft_match(radio_map, scan.bssid, scan.rssi_dbm)
    asked = soft_match(radio_map, scan.bssid, scan.rssi_dbm, floor=0)
    assert free is not None and asked is not None
    assert (radio_map.floors[free.floor], radio_map.floors[asked.floor]) == ("F1", "B1")
    assert free.floor_probability.argmax() == free.floor
