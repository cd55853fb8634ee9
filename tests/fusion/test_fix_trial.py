"""Fixes that contradict the steps are told from those that do not."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.fusion.fix_trial import TrialSettings, Tried, tried

SPREAD = np.diag([25.0, 25.0])
OURS = TrialSettings()


def seen_at(metres: float, streak: int = 0, settings: TrialSettings = OURS) -> Tried:
    return tried(3.0, np.array([metres, 0.0]), SPREAD, streak, settings)


def test_a_fix_near_by_passes_and_leaves_its_record() -> None:
    seen = seen_at(6.0, streak=2)
    assert seen.passed and not seen.fault and seen.streak == 0
    assert seen.check.statistic == pytest.approx(36.0 / 25.0) and seen.check.fused
    assert seen.phases.if1 == seen.phases.if2 == 0 and not seen.phases.excluded


def test_one_far_away_is_excluded_and_says_how_far() -> None:
    seen = seen_at(40.0)
    assert not seen.passed and not seen.fault and seen.streak == 1
    assert (seen.phases.if1, seen.phases.if2, seen.phases.if3) == (1, 1, 0)
    assert seen.phases.disagreement_m == 40.0 and "40 m" in seen.phases.excluded[0].reason


def test_several_in_a_row_are_a_fault() -> None:
    streak = 0
    for number in range(1, OURS.fault_after + 1):
        seen = seen_at(40.0, streak)
        streak = seen.streak
        assert seen.fault == (number == OURS.fault_after)


def test_errors_as_large_as_stated_fail_as_often_as_stated() -> None:
    rng, settings = np.random.default_rng(6), TrialSettings(false_alarm=0.01)
    failed = sum(not tried(0.0, e, SPREAD, 0, settings).passed for e in rng.normal(0.0, 5.0, (20_000, 2)))
    assert 150 < failed < 250


def test_untested_everything_passes_that_is_finite() -> None:
    settings = TrialSettings(tested=False)
    assert seen_at(4000.0, settings=settings).passed
    broken = tried(0.0, np.array([math.nan, 0.0]), SPREAD, 0, settings)
    assert not broken.passed and broken.phases.statistic is None and math.isfinite(broken.phases.disagreement_m)
