"""What a survey says of its own errors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import (
    DEFAULT,
    FEW_WALKS_WEIGHT,
    LEAST_FINENESS,
    LEAST_PERSISTENCE,
    LEAST_WALKS,
    SECTION,
    FixCalibration,
    calibrate,
    calibrated_map,
    calibration_of,
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


def test_a_map_of_the_two_releases_before_keeps_what_it_learnt() -> None:
    radio_map = calibrated_map(walks(20, 3.0))
    learnt = calibration_of(radio_map)
    as_now = replace(learnt, reach_68=1.0, persistence=1.0)

    def without(last: int) -> FixCalibration:
        sections = {**radio_map.sections, SECTION: radio_map.sections[SECTION][:-last]}
        return calibration_of(replace(radio_map, sections=sections))

    assert without(2) == as_now != learnt
    assert without(3) == replace(as_now, fineness=1.0)
    assert without(4) == DEFAULT


def test_a_corridor_whose_scans_err_each_for_itself_has_errors_that_last_less() -> None:
    many, few = calibrate(walks(40, 4.0)), calibrate(walks(LEAST_WALKS, 4.0))
    assert LEAST_PERSISTENCE <= many.persistence < few.persistence <= 1.0


def test_fingerprints_without_walks_leave_errors_as_lasting_as_they_can_be() -> None:
    alone = [replace(one, walk=f"alone{number}") for number, one in enumerate(walks(10, 4.0))]
    assert calibrate(alone).persistence == 1.0
