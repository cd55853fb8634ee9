"""What a survey says of its own errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import (
    DEFAULT,
    FEW_WALKS_WEIGHT,
    LEAST_FINENESS,
    LEAST_WALKS,
    SECTION,
    FixCalibration,
    calibrate,
    calibrated_map,
    calibration_of,
    conformal_reach,
)
from app.wifi.left_out import left_out_scans
from app.wifi.radio_map import build_radio_map
from app.wifi.radio_map_codec import decode_radio_map, encode_radio_map
from app.wifi.soft_match import soft_match
from tests.wifi.surveys import heard_at


def walks(count: int, noise_db: float, seed: int = 4) -> list[Fingerprint]:
    """Walks along a corridor, a scan every 2 m."""
    rng = np.random.default_rng(seed)
    survey = []
    for walk in range(count):
        for x_m in np.arange(float(rng.uniform(0.0, 2.0)), 41.0, 2.0):
            scan = heard_at(float(x_m), 0, rng, noise_db)
            place = Fingerprint("F1", float(x_m), 1.0, float(walk), f"walk{walk}", scan.bssid, scan.rssi_dbm)
            survey.append(place)
    return survey


def test_a_noisier_building_is_given_larger_errors() -> None:
    calm, noisy = calibrate(walks(40, 1.0)), calibrate(walks(40, 7.0))
    assert calm.walks == noisy.walks == 40
    scan = heard_at(20.0, 0, np.random.default_rng(1), 0.0)
    radio_map = build_radio_map(walks(40, 1.0))
    match = soft_match(radio_map, scan.bssid, scan.rssi_dbm)
    assert match is not None
    assert noisy.variance_m2(match) > 1.3 * calm.variance_m2(match)


def test_the_variance_is_nearer_to_the_errors_it_was_learnt_from_than_the_defaults_are() -> None:
    survey = walks(60, 4.0)
    placed = left_out_scans(survey)

    def excess(numbers: FixCalibration) -> float:
        variance_m2 = np.array([numbers.variance_m2(match) for match in placed.match])
        return float(np.mean(placed.error_m**2 / (2.0 * variance_m2)))  # 1 where it is right

    assert abs(np.log(excess(calibrate(survey)))) < 0.6 * abs(np.log(excess(DEFAULT)))


def test_a_walk_is_never_judged_by_a_map_it_is_part_of() -> None:
    error_m = left_out_scans([replace(one, walk="only") for one in walks(1, 2.0)]).error_m
    assert len(error_m) == 0


def test_a_survey_of_few_walks_leaves_the_defaults_but_trusts_strange_scans_less() -> None:
    cautious = replace(DEFAULT, distance_m2=FEW_WALKS_WEIGHT * DEFAULT.distance_m2)
    assert calibrate(walks(LEAST_WALKS - 1, 2.0)) == cautious == calibrate([])
    assert calibration_of(build_radio_map(walks(2, 2.0))) == DEFAULT


def test_what_was_learnt_is_stored_with_the_map() -> None:
    survey = walks(20, 3.0)
    stored = decode_radio_map(encode_radio_map(calibrated_map(survey, version=3)))
    assert stored.version == 3
    assert calibration_of(stored) == calibrate(survey) != DEFAULT


def test_a_building_whose_fixes_err_less_is_finer_and_none_is_coarser() -> None:
    calm, noisy, few = calibrate(walks(40, 1.0)), calibrate(walks(40, 20.0)), calibrate(walks(LEAST_WALKS, 1.0))
    assert LEAST_FINENESS <= calm.fineness < few.fineness < 1.0
    assert calm.fineness < noisy.fineness <= 1.0


def test_a_map_of_the_release_before_keeps_what_it_learnt() -> None:
    radio_map = calibrated_map(walks(20, 3.0))
    learnt = calibration_of(radio_map)
    earlier = replace(radio_map, sections={**radio_map.sections, SECTION: radio_map.sections[SECTION][:-1]})
    assert calibration_of(earlier) == replace(learnt, fineness=1.0)
    before_that = replace(radio_map, sections={**radio_map.sections, SECTION: radio_map.sections[SECTION][:-2]})
    assert calibration_of(before_that) == DEFAULT


def test_the_conformal_reach_counts_each_walk_once() -> None:
    """A thousand scans of one walk say no more than the one scan of each of the 99 others."""
    score = np.concatenate([np.full(1000, 90.5), np.arange(1.0, 100.0)])
    walk = np.concatenate([np.zeros(1000, np.int64), np.arange(1, 100)])
    assert conformal_reach(score, walk, 0.5) in (50.0, 51.0)


@given(st.integers(20, 200), st.integers(0, 2**31))
def test_a_new_walk_stays_below_the_conformal_reach_as_often_as_promised(walks: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    held = [
        rng.exponential() <= conformal_reach(rng.exponential(size=walks), np.arange(walks), 0.9) for _ in range(200)
    ]
    assert np.mean(held) > 0.8


def test_a_share_that_so_few_walks_cannot_support_gives_the_largest_score() -> None:
    assert conformal_reach(np.arange(5.0), np.arange(5), 0.95) == 4.0
