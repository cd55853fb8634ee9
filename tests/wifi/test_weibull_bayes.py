"""Weibull parameters and the posterior, against the formulas written out (docs/methods/integrity_ukf.md)."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.weibull import weibull_of, window_likelihood
from app.wifi.weibull_bayes import PAPER, WeibullSettings, mean_log_likelihoods, weibull_bayes
from tests.wifi.surveys import ACCESS_POINTS, corridor, fingerprints, heard_at
from tests.wifi.test_radio_map import pairs

SCANS = st.dictionaries(st.integers(1, ACCESS_POINTS), st.integers(-100, -20), min_size=1)


def plain_parameters(mean: float, std: float) -> tuple[float, float, float]:
    k = min(max(std / math.log(2), 1.5), 2.5)
    lam = min(max(std, 2.0), 3.5) * (k + 0.15)
    return k, lam, mean - lam * math.gamma(1 + 1 / k)


def plain_likelihood(r: float, k: float, lam: float, theta: float) -> float:
    def cdf(x: float) -> float:
        return 1.0 - math.exp(-(((x - theta) / lam) ** k)) if x > theta else 0.0

    return cdf(r + 5.0) - cdf(r - 5.0)


@given(mean=st.floats(-100, -20), std=st.floats(0, 20), reading=st.floats(-120, 0))
def test_parameters_and_likelihood_are_those_of_the_formulas(mean: float, std: float, reading: float) -> None:
    weibull = weibull_of(np.array([mean]), np.array([std]))
    expected = plain_parameters(mean, std)
    found = (weibull.k[0], weibull.lambda_db[0], weibull.theta_dbm[0])
    assert found == pytest.approx(expected, rel=1e-5)
    likelihood = window_likelihood(np.array(reading), *(np.array(value) for value in expected))
    assert float(likelihood) == pytest.approx(plain_likelihood(reading, *expected), abs=1e-12)


def plain_log_likelihood(radio_map: RadioMap, point: int, scan: dict[int, int], least: float) -> float:
    at = pairs(radio_map)
    known = set(radio_map.bssid.tolist())
    total = 0.0
    for address, rssi in scan.items():
        if address not in known:
            continue
        likelihood = 0.0
        if (point, address) in at:
            pair = at[point, address]
            std = math.sqrt(radio_map.variance_db2[pair]) if radio_map.count[pair] > 1 else 3.5
            likelihood = plain_likelihood(rssi, *plain_parameters(float(radio_map.mean_dbm[pair]), std))
        total += math.log(max(likelihood, least))
    return total / len(known & set(scan))


@given(survey=fingerprints(), scan=SCANS)
def test_the_table_gives_the_logs_of_the_likelihoods(survey: list[Fingerprint], scan: dict[int, int]) -> None:
    radio_map = build_radio_map(survey)
    if not set(scan) & set(radio_map.bssid.tolist()):
        scan = {int(radio_map.bssid[0]): -60, **scan}
    found = mean_log_likelihoods(radio_map, np.array(list(scan)), np.array(list(scan.values()), dtype=float))
    expected = [plain_log_likelihood(radio_map, point, scan, PAPER.least_likelihood) for point in range(len(found))]
    # the table rounds the mean by 0.05 dB at most, which moves the log most where the likelihood is least
    assert found == pytest.approx(expected, abs=0.35)
    assert np.median(np.abs(found - expected)) < 0.12


@pytest.mark.parametrize("settings", [WeibullSettings(), PAPER], ids=["ours", "paper"])
def test_a_scan_in_the_corridor_is_placed_there(settings: WeibullSettings) -> None:
    radio_map = build_radio_map(corridor())
    rng = np.random.default_rng(5)
    errors_m = []
    for x_m in rng.uniform(2.0, 38.0, 40):
        scan = heard_at(float(x_m), 1, rng)
        match = weibull_bayes(radio_map, scan.bssid, scan.rssi_dbm, settings)
        assert match is not None
        assert radio_map.floors[match.floor] == "F1"
        assert match.weight.sum() == pytest.approx(1.0)
        errors_m.append(abs(match.xy_m[0] - x_m))
    assert np.mean(errors_m) < 2.0


def test_access_points_that_nobody_surveyed_give_no_match() -> None:
    radio_map = build_radio_map(corridor())
    assert weibull_bayes(radio_map, np.array([9999]), np.array([-50.0])) is None
    assert weibull_bayes(build_radio_map([]), np.array([9999]), np.array([-50.0])) is None
