"""When a rival account of the walk begins to count, wins, and is forgotten."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.floorplan.free_space import NO_PLAN
from app.fusion.cloud_settings import CloudSettings
from app.fusion.hypotheses import HypothesisSettings, Rivalry, exchanged, first_is_back, judged, rival_wins
from app.fusion.particle_cloud import begun

SETTINGS = HypothesisSettings()
CLEAR = SETTINGS.enough_against
"""Squared distance of a scan that leaves no doubt."""
BARELY = 1.01 * SETTINGS.contradicts
TRACK = begun(np.zeros(2), 1.0, 1.0, 0.0, NO_PLAN, CloudSettings())
FAR = begun(np.array([50.0, 0.0]), 1.0, 1.0, 0.0, NO_PLAN, CloudSettings())


def after(*scans: tuple[bool, bool], walked_m: float = 0.0) -> Rivalry:
    """The record after scans, each of which fits the first track, the rival, both or neither."""
    rivalry = Rivalry(FAR, 0.0, walked_m=walked_m)
    for first, rival in scans:
        rivalry = judged(rivalry, CLEAR, first, rival, 0.0, SETTINGS)
    return rivalry


def test_the_first_contradiction_warns_nobody_and_the_second_does() -> None:
    assert not after().fault
    assert after((False, True)).fault
    assert after((False, False)).fault


def test_scans_that_barely_contradict_warn_only_when_they_go_on() -> None:
    rivalry = Rivalry(FAR, 0.0, against=BARELY)
    for _ in range(SETTINGS.surely_after - 1):
        assert not rivalry.fault
        rivalry = judged(rivalry, BARELY, False, True, 0.0, SETTINGS)
    assert rivalry.fault


def test_what_contradicted_before_a_scan_that_fits_is_not_held_against_the_track() -> None:
    rivalry = judged(Rivalry(FAR, 0.0, against=CLEAR), 0.0, True, True, 0.0, SETTINGS)
    for _ in range(SETTINGS.fault_after):
        rivalry = judged(rivalry, BARELY, False, True, 0.0, SETTINGS)
    assert not rivalry.fault


def test_scans_that_sound_like_the_first_track_too_warn_nobody_until_the_rival_takes_over() -> None:
    rivalry = Rivalry(FAR, 0.0, contradictions=0, walked_m=SETTINGS.moved_m)
    for _ in range(SETTINGS.moved_after):
        assert not rivalry.fault
        rivalry = judged(rivalry, CLEAR, False, True, 0.0, SETTINGS, explained=True)
    assert not rivalry.fault and rivalry.contradictions == 0
    assert judged(judged(rivalry, CLEAR, False, True, 0.0, SETTINGS), CLEAR, False, True, 0.0, SETTINGS).fault
    assert rival_wins(rivalry, SETTINGS) and exchanged(rivalry, TRACK).fault


def test_a_scan_that_fits_ends_an_outlier_at_once_and_a_fault_only_with_a_second() -> None:
    assert first_is_back(after((True, False)), SETTINGS)
    assert not first_is_back(after((False, True), (True, False)), SETTINGS)
    assert first_is_back(after((False, True), (True, False), (True, False)), SETTINGS)


def test_the_rival_wins_by_five_scans_on_ten_metres_and_by_neither_alone() -> None:
    scans = [(False, True)] * (SETTINGS.moved_after - 1)
    assert rival_wins(after(*scans, walked_m=SETTINGS.moved_m), SETTINGS)
    assert not rival_wins(after(*scans[1:], walked_m=100.0), SETTINGS)
    assert not rival_wins(after(*scans, walked_m=SETTINGS.moved_m - 0.1), SETTINGS)


def test_scans_that_fit_both_accounts_do_not_help_the_rival() -> None:
    assert after(*[(True, True)] * 10).for_rival == 1


def test_after_a_takeover_the_phone_stays_warned_until_a_longer_way_bears_it_out() -> None:
    won = after(*[(False, True)] * 5, walked_m=15.0)
    taken = exchanged(won, TRACK)
    assert taken.fault and taken.rival is TRACK and taken.taken_over
    for _ in range(SETTINGS.settled_after):
        assert not first_is_back(taken, SETTINGS)
        taken = judged(taken, CLEAR, True, False, 0.0, SETTINGS)
    assert not first_is_back(taken, SETTINGS)
    walked = replace(taken, walked_m=SETTINGS.settled_m)
    assert first_is_back(walked, SETTINGS)


def test_a_takeover_by_mistake_is_undone_by_two_scans() -> None:
    taken = exchanged(after(*[(False, True)] * 5, walked_m=15.0), TRACK)
    taken = judged(judged(taken, CLEAR, False, True, 0.0, SETTINGS), CLEAR, False, True, 0.0, SETTINGS)
    assert rival_wins(taken, SETTINGS)
    assert not exchanged(taken, FAR).taken_over


@given(scans=st.lists(st.tuples(st.booleans(), st.booleans()), max_size=30))
def test_a_warning_is_never_taken_back_by_the_record_alone(scans: list[tuple[bool, bool]]) -> None:
    warned = False
    rivalry = Rivalry(FAR, 0.0)
    for first, rival in scans:
        rivalry = judged(rivalry, CLEAR, first, rival, 0.0, SETTINGS)
        assert rivalry.fault or not warned
        warned = rivalry.fault
