from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app.evaluation.campaign import read_walks
from app.evaluation.exclusions import FAULTY_SCANS, LOUD_DBM, ExclusionCount, InPlay, exclusions, in_play
from app.evaluation.faulty_walk import FaultyWalk
from app.evaluation.recordings import RecordedWalk, floor_folders
from app.observations import WifiScan
from tests.evaluation.answers import answer


@pytest.fixture(scope="module")
def walk(small_site: Path) -> RecordedWalk:
    return read_walks(floor_folders(small_site, ["F1"]))[0]


def _hearing(walk: RecordedWalk, *heard: tuple[int, float, int]) -> RecordedWalk:
    """The walk hearing each access point at one level in so many scans."""
    scans = []
    for number in range(max(times for _, _, times in heard)):
        now = [(bssid, level_dbm) for bssid, level_dbm, times in heard if number < times]
        bssid, rssi_dbm = np.array([one for one, _ in now]), np.array([level_dbm for _, level_dbm in now])
        scans.append(WifiScan(float(number), bssid, rssi_dbm, np.full(len(now), float(number))))
    return replace(walk, trace=replace(walk.trace, scans=tuple(scans)))


def test_faulty_ones_are_to_be_found_where_they_are_loud_be_it_before_the_fault_or_with_it(walk: RecordedWalk) -> None:
    before = _hearing(walk, (1, LOUD_DBM, FAULTY_SCANS), (2, LOUD_DBM - 1.0, 9), (4, -50.0, 9))
    faulty = _hearing(walk, (2, LOUD_DBM - 1.0, 9), (3, -50.0, FAULTY_SCANS - 1), (4, -50.0, 9))
    found = in_play(FaultyWalk(faulty, 0.0, 9.0, frozenset({1, 2, 3})), before)
    assert found.faulty == {1}
    assert found.sound == {4}


def test_what_was_left_out_at_any_time_counts_once_a_walk() -> None:
    playing = {(0, "F1", "one"): InPlay(frozenset({1, 2}), frozenset({7, 8, 9}))}
    told = [answer(excluded=frozenset(out)) for out in ({1}, {1, 7}, set(), {99})]
    elsewhere = answer(walk="other", excluded=frozenset({2, 8}))
    assert exclusions([*told, elsewhere], playing) == ExclusionCount(2, 1, 3, 1, 1)


def test_walks_without_answers_and_answers_without_walks_have_nothing_to_find() -> None:
    assert exclusions([answer(excluded=frozenset({1}))], {}) == ExclusionCount(0, 0, 0, 0, 0)
    assert exclusions([], {(0, "F1", "one"): InPlay(frozenset({1}), frozenset({2}))}) == ExclusionCount(1, 0, 1, 0, 0)
