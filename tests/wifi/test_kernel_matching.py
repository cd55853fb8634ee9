"""Kernel-density matching against its formulas (docs/methods/dual_ukf.md)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import gaussian_kde

from app.wifi.fingerprint import Fingerprint
from app.wifi.kernel_matching import PAPER, KernelSettings, kernel_match, mean_squares, silverman_sigma
from app.wifi.radio_map import build_radio_map
from tests.wifi.surveys import ACCESS_POINTS, corridor, fingerprints, heard_at
from tests.wifi.test_radio_map import pairs

SCANS = st.dictionaries(st.integers(1, ACCESS_POINTS), st.integers(-100, -20), min_size=1)


@given(survey=fingerprints(), scan=SCANS)
def test_differences_are_means_over_what_both_heard(survey: list[Fingerprint], scan: dict[int, int]) -> None:
    radio_map = build_radio_map(survey)
    at = pairs(radio_map)
    square_db2, shared = mean_squares(radio_map, *arrays(scan), PAPER)
    for point in range(len(radio_map.scans)):
        both = [(rssi, radio_map.mean_dbm[at[point, i]]) for i, rssi in scan.items() if (point, i) in at]
        assert shared[point] == len(both)
        expected = sum((rssi - mean) ** 2 for rssi, mean in both) / len(both) if both else math.inf
        assert square_db2[point] == pytest.approx(expected)


@given(survey=fingerprints(), scan=SCANS)
def test_a_filled_point_hears_at_the_given_level_what_it_never_heard(
    survey: list[Fingerprint], scan: dict[int, int]
) -> None:
    radio_map = build_radio_map(survey)
    at, known = pairs(radio_map), set(radio_map.bssid.tolist())
    square_db2, shared = mean_squares(radio_map, *arrays(scan), KernelSettings(missing_dbm=-95.0))
    strength = {i: max(rssi + 105.0, 0.0) ** math.e for i, rssi in scan.items() if i in known}
    for point in np.flatnonzero(shared).tolist():
        heard = {i: float(radio_map.mean_dbm[at[point, i]]) if (point, i) in at else -95.0 for i in strength}
        expected = sum(w * (scan[i] - heard[i]) ** 2 for i, w in strength.items()) / sum(strength.values())
        assert square_db2[point] == pytest.approx(expected, rel=1e-4, abs=1e-3)


def test_bandwidth_is_silvermans() -> None:
    rng = np.random.default_rng(5)
    for access_points, points in ((1, 100), (20, 500)):
        kernels = gaussian_kde(rng.normal(size=(access_points, points)), "silverman")
        assert silverman_sigma(3.0, access_points, points) == pytest.approx(3.0 * kernels.factor)


@pytest.mark.parametrize("settings", [KernelSettings(), PAPER], ids=["ours", "paper"])
def test_a_scan_in_the_corridor_is_placed_there(settings: KernelSettings) -> None:
    radio_map = build_radio_map(corridor())
    rng = np.random.default_rng(6)
    errors_m = []
    for x_m in rng.uniform(2.0, 38.0, 40):
        scan = heard_at(float(x_m), 1, rng)
        match = kernel_match(radio_map, scan.bssid, scan.rssi_dbm, settings)
        assert match is not None
        errors_m.append(abs(match.xy_m[0] - x_m))
    assert np.mean(errors_m) < 2.5


def test_the_covariance_is_the_movement_and_the_scatter() -> None:
    radio_map = build_radio_map(corridor())
    scan = heard_at(20.0, 1, np.random.default_rng(3))
    match = kernel_match(radio_map, scan.bssid, scan.rssi_dbm, KernelSettings(movement_sigma_m=3.0))
    assert match is not None
    scatter = np.cov(radio_map.xy_m[match.points].T, aweights=match.weight, ddof=0)
    assert match.covariance_m2 == pytest.approx(scatter + 9.0 * np.eye(2))


def test_weights_are_a_gaussian_kernel_of_the_differences() -> None:
    radio_map = build_radio_map(corridor())
    scan = heard_at(20.0, 1, np.random.default_rng(3))
    match = kernel_match(radio_map, scan.bssid, scan.rssi_dbm, KernelSettings(least_sigma_db=6.0, witnesses=2.0))
    assert match is not None
    sigma_db = silverman_sigma(6.0, match.known, len(radio_map.scans))  # readings here vary by 2 dB only
    expected = np.exp(-0.5 * 2.0 * match.distance**2 / sigma_db**2)
    assert match.weight == pytest.approx(expected / expected.sum())


def test_nothing_known_gives_no_match() -> None:
    assert kernel_match(build_radio_map(corridor()), np.array([9999]), np.array([-50.0])) is None
    assert kernel_match(build_radio_map([]), np.array([9999]), np.array([-50.0])) is None


def arrays(scan: dict[int, int]) -> tuple[np.ndarray, np.ndarray]:
    return np.array(list(scan)), np.array(list(scan.values()), dtype=np.float64)


def test_a_scan_too_weak_to_weigh_anything_places_nobody() -> None:
    radio_map = build_radio_map([Fingerprint("F1", 0.0, 0.0, 0.0, "walk", np.array([1, 2]), np.array([-60.0, -70.0]))])
    assert kernel_match(radio_map, np.array([1, 2]), np.array([-120.0, -115.0])) is None
