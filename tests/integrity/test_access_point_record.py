from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.estimation.arrays import FloatArray
from app.integrity.access_point_faults import ScanEvidence
from app.integrity.access_point_record import (
    AccessPointFault,
    AccessPointRecord,
    RecordSettings,
    kinds_of,
    nothing_recorded,
    recorded,
)

SETTINGS = RecordSettings()
ENOUGH = 5
"""Scans that speak against an access point as strongly as they can, until it is left out."""


def _scan(
    evidence: list[float],
    level_db: list[float] | None = None,
    expected_db: list[float] | None = None,
    bssid: list[int] | None = None,
) -> ScanEvidence:
    count = len(evidence)
    return ScanEvidence(
        bssid=np.array(bssid or range(1, count + 1), np.int64),
        evidence=np.array(evidence),
        level_db=np.array(level_db or [-60.0] * count),
        expected_db=np.array(expected_db or [np.nan] * count),
        judged=np.ones(count, np.bool_),
        confirmed=np.array(evidence) < -1.0,
        suspicious=0.0,
    )


def _after(scans: list[ScanEvidence], stride_m: float = 2.0) -> AccessPointRecord:
    record = nothing_recorded()
    for number, scan in enumerate(scans):
        record = recorded(record, scan, scan.level_db, np.array([stride_m * number, 0.0]), SETTINGS)
    return record


def _kind(scans: list[ScanEvidence], at: int = 0, stride_m: float = 2.0) -> AccessPointFault:
    return kinds_of(_after(scans, stride_m), SETTINGS)[at]


def test_one_that_goes_wrong_again_and_again_is_left_out_and_the_others_are_not_on_record() -> None:
    record = _after([_scan([-2.0, 3.0, 0.2])] * ENOUGH)
    assert record.bssid.tolist() == [2]
    assert record.excluded.tolist() == [True]
    assert not _after([_scan([-2.0, 3.0, 0.2])] * 2).excluded.any()


def test_a_long_good_record_does_not_hide_a_change() -> None:
    good = [_scan([-3.0, -3.0])] * 50
    assert _after(good).bssid.tolist() == []
    assert _after([*good, *[_scan([3.0, -3.0])] * ENOUGH]).bssid[0] == 1


def test_one_that_is_as_surveyed_again_is_used_again_however_long_it_was_not() -> None:
    wrong = [_scan([3.0])] * 40
    assert _after([*wrong, _scan([-3.0])]).excluded.tolist() == [True]
    assert _after([*wrong, *[_scan([-3.0])] * 5]).excluded.tolist() in ([], [False])


def test_one_that_comes_and_goes_does_not_flicker() -> None:
    wrong = [_scan([3.0])] * ENOUGH
    flickering = [_scan([-3.0]), _scan([3.0])] * 10
    for n in range(1, len(flickering)):
        assert _after([*wrong, *flickering[:n]]).excluded.tolist() == [True]


@given(st.lists(st.lists(st.floats(-3.0, 3.0), min_size=200, max_size=200), min_size=1, max_size=8))
def test_the_record_is_bounded_and_holds_the_worst(scans: list[list[float]]) -> None:
    record = _after([_scan(evidence) for evidence in scans])
    assert len(record.bssid) <= SETTINGS.most
    assert np.all(np.diff(record.bssid) > 0)
    assert np.all((record.score >= SETTINGS.kept_at) & (record.score <= SETTINGS.most_score))
    only = np.array(scans[0])
    if len(scans) == 1 and (only > 1.0).sum() > SETTINGS.most:
        assert record.score.min() >= np.sort(only)[-SETTINGS.most]


def test_access_points_that_the_map_no_longer_has_are_forgotten() -> None:
    record = _after([_scan([3.0, 3.0])] * ENOUGH)
    later = recorded(record, _scan([3.0], bssid=[2]), np.array([-60.0]), np.zeros(2), SETTINGS)
    assert later.bssid.tolist() == [2]


def test_one_that_is_silent_where_it_was_heard_has_vanished() -> None:
    assert _kind([_scan([2.2], [np.nan], [-60.0])] * 6) is AccessPointFault.VANISHED


def test_one_that_is_heard_where_it_never_was_has_moved() -> None:
    levels = [-50.0, -58.0, -66.0, -60.0, -49.0]
    assert _kind([_scan([3.0], [level]) for level in levels]) is AccessPointFault.MOVED


def test_one_that_is_equally_loud_over_a_stretch_of_way_is_spoofed_but_not_at_one_place() -> None:
    steady = [_scan([3.0], [-50.0])] * ENOUGH
    assert _kind(steady, stride_m=4.0) is AccessPointFault.SPOOFED
    assert _kind(steady, stride_m=0.0) is AccessPointFault.MOVED


def test_one_that_is_heard_at_home_and_elsewhere_too_is_duplicated() -> None:
    elsewhere = [_scan([3.0], [level]) for level in (-50.0, -58.0, -66.0, -60.0, -49.0)]
    at_home = [_scan([-0.5], [level], [-62.0]) for level in (-60.0, -66.0)]
    assert _kind([*elsewhere, *at_home]) is AccessPointFault.DUPLICATED


def test_two_that_sound_as_the_other_should_are_swapped_and_each_knows_the_other() -> None:
    own: list[FloatArray] = [np.array([-50.0 - 2.0 * n, -80.0 + 2.0 * n, -65.0]) for n in range(ENOUGH)]
    scans = [_scan([3.0, 3.0, -2.0], level[[1, 0, 2]].tolist(), level.tolist()) for level in own]
    record = _after(scans)
    assert record.partner.tolist() == [2, 1]
    assert kinds_of(record, SETTINGS) == [AccessPointFault.SWAPPED] * 2
