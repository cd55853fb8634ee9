"""What a radio map is made of."""

from __future__ import annotations

import math
import random
import statistics

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.fingerprint import Fingerprint
from app.wifi.radio_map import RadioMap, build_radio_map
from app.wifi.radio_map_codec import encode_radio_map
from tests.wifi.surveys import fingerprint, fingerprints


def pairs(radio_map: RadioMap) -> dict[tuple[int, int], int]:
    """Position in the map's arrays by (reference point, address)."""
    addresses = radio_map.bssid[radio_map.access_point]
    return {pair: at for at, pair in enumerate(zip(radio_map.point.tolist(), addresses.tolist(), strict=True))}


@given(survey=fingerprints())
def test_each_pair_has_the_statistics_of_the_scans_that_heard_it(survey: list[Fingerprint]) -> None:
    radio_map = build_radio_map(survey)
    heard: dict[tuple[int, int], list[float]] = {}
    made_of: dict[int, list[Fingerprint]] = {}
    for one in survey:
        point = point_of(radio_map, one, survey)
        made_of.setdefault(point, []).append(one)
        for address, rssi in zip(one.bssid.tolist(), one.rssi_dbm.tolist(), strict=True):
            heard.setdefault((point, address), []).append(rssi)
    assert set(pairs(radio_map)) == set(heard)
    for pair, at in pairs(radio_map).items():
        readings = heard[pair]
        assert radio_map.count[at] == len(readings)
        assert radio_map.mean_dbm[at] == pytest.approx(statistics.fmean(readings), abs=1e-4)
        variance = statistics.variance(readings) if len(readings) > 1 else 0.0
        assert radio_map.variance_db2[at] == pytest.approx(variance, rel=1e-5, abs=1e-4)
        assert radio_map.share_heard[at] == pytest.approx(len(readings) / len(made_of[pair[0]]))
    for point, scans in made_of.items():
        assert radio_map.scans[point] == len(scans)
        assert radio_map.xy_m[point, 0] == pytest.approx(statistics.fmean(one.x_m for one in scans))
        assert radio_map.xy_m[point, 1] == pytest.approx(statistics.fmean(one.y_m for one in scans))


def point_of(radio_map: RadioMap, one: Fingerprint, survey: list[Fingerprint]) -> int:
    """The reference point that a fingerprint belongs to, by the rule as written."""
    same = [other for other in survey if (other.floor, other.x_m, other.y_m) == (one.floor, one.x_m, one.y_m)]
    members = (
        same if len(same) > 1 else [other for other in survey if cell(other) == cell(one) and alone(other, survey)]
    )
    x_m = statistics.fmean(other.x_m for other in members)
    y_m = statistics.fmean(other.y_m for other in members)
    floor = radio_map.floors.index(one.floor)
    near = np.hypot(radio_map.xy_m[:, 0] - x_m, radio_map.xy_m[:, 1] - y_m) < 1e-9
    at = np.flatnonzero(near & (radio_map.floor == floor) & (radio_map.scans == len(members)))
    return int(at[0])


def cell(one: Fingerprint) -> tuple[str, int, int]:
    return one.floor, math.floor(one.x_m / 1.5), math.floor(one.y_m / 1.5)


def alone(one: Fingerprint, survey: list[Fingerprint]) -> bool:
    return sum((other.floor, other.x_m, other.y_m) == (one.floor, one.x_m, one.y_m) for other in survey) == 1


@given(survey=fingerprints(), seed=st.integers(0, 99))
def test_the_order_of_fingerprints_does_not_matter(survey: list[Fingerprint], seed: int) -> None:
    shuffled = random.Random(seed).sample(survey, len(survey))
    assert encode_radio_map(build_radio_map(shuffled)) == encode_radio_map(build_radio_map(survey))


@given(survey=fingerprints())
def test_pairs_are_ordered_by_access_point_and_then_by_point(survey: list[Fingerprint]) -> None:
    radio_map = build_radio_map(survey)
    order = list(zip(radio_map.access_point.tolist(), radio_map.point.tolist(), strict=True))
    assert order == sorted(set(order))
    assert np.all(np.diff(radio_map.bssid) > 0)


def test_scans_of_one_place_stay_together_and_apart_from_their_cell() -> None:
    survey = [fingerprint("F1", x_m, 0.2, {1: -50}, time_s=x_m) for x_m in (0.1, 0.3, 0.3, 0.5)]
    radio_map = build_radio_map(survey)
    assert sorted(zip(radio_map.xy_m[:, 0].round(6).tolist(), radio_map.scans.tolist(), strict=True)) == [
        (0.3, 2),
        (0.3, 2),
    ]


def test_without_cells_every_fingerprint_is_a_point() -> None:
    survey = [fingerprint("F1", 1.0, 1.0, {1: -50}, time_s=float(t)) for t in range(3)]
    assert build_radio_map(survey, cell_m=0.0).scans.tolist() == [1, 1, 1]


def test_floors_are_kept_apart() -> None:
    radio_map = build_radio_map([fingerprint("F1", 0.0, 0.0, {1: -50}), fingerprint("B1", 0.0, 0.0, {1: -70})])
    assert radio_map.floors == ("B1", "F1")
    assert radio_map.floor.tolist() == [0, 1]
    assert radio_map.mean_dbm.tolist() == [-70.0, -50.0]


def test_no_fingerprints_make_an_empty_map() -> None:
    radio_map = build_radio_map([], version=4)
    assert radio_map.version == 4
    assert radio_map.floors == ()
    assert radio_map.start.tolist() == [0]
    assert [len(part) for part in (radio_map.bssid, radio_map.scans, radio_map.point, radio_map.mean_dbm)] == [0] * 4
    assert radio_map.xy_m.shape == (0, 2)
