"""Survey scans through a running median."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given

from app.wifi.fingerprint import Fingerprint
from app.wifi.median_filter import median_filtered
from tests.wifi.surveys import fingerprint, fingerprints


def series(*readings: int) -> list[Fingerprint]:
    return [fingerprint("F1", 1.0, 2.0, {7: rssi}, time_s=float(number)) for number, rssi in enumerate(readings)]


def levels(filtered: list[Fingerprint]) -> list[float]:
    return [float(one.rssi_dbm[0]) for one in filtered]


def test_a_single_bad_reading_is_gone() -> None:
    assert levels(median_filtered(series(-60, -60, -60, -95, -61, -61, -61))) == [-60, -60, -60, -61, -61, -61, -61]


def test_time_counts_not_the_order_of_the_survey() -> None:
    survey = series(-60, -60, -60, -95, -61, -61, -61)
    assert levels(median_filtered(survey[::-1]))[::-1] == levels(median_filtered(survey))


def test_other_places_floors_and_access_points_have_nothing_to_say() -> None:
    one = fingerprint("F1", 1.0, 2.0, {7: -60, 8: -40}, time_s=0.0)
    others = [replace(one, x_m=5.0, time_s=1.0), replace(one, floor="F2", time_s=2.0)]
    quieter = [replace(other, rssi_dbm=other.rssi_dbm - 30.0) for other in others]
    assert median_filtered([one, *quieter])[0].rssi_dbm.tolist() == one.rssi_dbm.tolist()


@given(survey=fingerprints())
def test_a_filter_of_order_one_changes_nothing(survey: list[Fingerprint]) -> None:
    for before, after in zip(survey, median_filtered(survey, 1), strict=True):
        assert np.array_equal(before.rssi_dbm, after.rssi_dbm) and np.array_equal(before.bssid, after.bssid)


@pytest.mark.parametrize("order", [0, 4, -3])
def test_an_order_that_has_no_middle_is_refused(order: int) -> None:
    with pytest.raises(ValueError, match="odd"):
        median_filtered([], order)
