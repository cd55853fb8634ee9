"""What the two filters do together, and what each part of the method is worth."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.evaluation.alone import ALONE
from app.fusion import position_ekf as ekf
from app.fusion.interface import Method, SessionStart, Site
from app.fusion.two_stage_ekf import TWO_STAGE_EKF, TwoStageState, start, two_stage_ekf
from app.fusion.two_stage_settings import TwoStageSettings
from app.observations import AxisSamples, Batch
from tests.fusion.walks import errors_m, places_m, run, site, walked, without

WALK = walked(5, length_m=150.0)
OURS = TwoStageSettings()


def states(
    batches: tuple[Batch, ...] | list[Batch], method: Method = TWO_STAGE_EKF, on: Site | None = None
) -> list[TwoStageState]:
    state, found = start(SessionStart()), []
    for batch in batches:
        state, _ = method.advance(state, batch, on or site())
        found.append(state)
    return found


def test_the_compass_is_asked_once_and_the_gyroscope_from_there_on() -> None:
    """A compass that goes wrong after the start changes nothing."""
    begun = next(number for number, state in enumerate(states(WALK.batches)) if state.track and state.track.headed)
    wrong = []
    for number, batch in enumerate(WALK.batches):
        if number > begun + 1:
            turned = batch.rotation_vector.values[:, [1, 0, 2]]
            batch = replace(batch, rotation_vector=AxisSamples(batch.rotation_vector.time_s, turned))
        wrong.append(batch)
    apart_m = np.hypot(*(places_m(run(TWO_STAGE_EKF, wrong)) - places_m(run(TWO_STAGE_EKF, WALK.batches))).T)
    assert apart_m.max() < 0.5


def test_after_a_gap_in_the_gyroscope_the_heading_is_asked_for_again() -> None:
    cut = [without(batch, "gyroscope") if 30 <= number < 36 else batch for number, batch in enumerate(WALK.batches)]
    found = states(cut)
    before, after = found[28].track, found[60].track
    assert before is not None and after is not None
    assert after.stretch == before.stretch + 1 and after.headed
    assert errors_m(WALK, run(TWO_STAGE_EKF, cut))[-20:].mean() < 6.0


def test_the_partition_serves_most_scans_and_answers_like_the_full_search() -> None:
    full = ALONE["two_stage_ekf_full_search"]
    held = [state.search.partition for state in states(WALK.batches) if state.radio_s is not None]
    assert sum(partition is not None for partition in held) > 0.9 * len(held)
    assert {state.search.partition for state in states(WALK.batches, full)} == {None}
    moving, whole = errors_m(WALK, run(TWO_STAGE_EKF, WALK.batches)), errors_m(WALK, run(full, WALK.batches))
    assert moving.mean() < whole.mean() + 0.5


def test_a_radio_map_published_mid_walk_is_searched_from_the_next_scan_on() -> None:
    known = site()
    assert known.radio_map is not None
    newer = Site(known.floors, replace(known.radio_map, version=8))
    state = start(SessionStart())
    for number, batch in enumerate(WALK.batches[:60]):
        state, _ = TWO_STAGE_EKF.advance(state, batch, known if number < 30 else newer)
    assert state.search.version == 8


def test_a_direction_is_measured_on_a_straight_way_and_not_across_a_corner() -> None:
    across, straight = 0, 0
    for seed in (1, 2, 4, 5):
        batches = walked(seed, 150.0).batches
        found = states(batches)
        for before, state, fix in zip(found, found[1:], run(TWO_STAGE_EKF, batches)[1:], strict=False):
            if any(check.source == "direction" for check in fix.checks):
                straight += 1
                across += before.turned_s > state.fixes[0, 0]
    assert straight > 10 and across == 0


def test_step_length_follows_the_accelerometer() -> None:
    track = states(WALK.batches)[-1].track
    assert track is not None
    lengths = [
        check.innovation[0]
        for fix in run(TWO_STAGE_EKF, WALK.batches)
        for check in fix.checks
        if check.source == "step"
    ]
    assert abs(np.mean(lengths[20:])) < 0.05
    assert 0.4 < track.mean[ekf.LENGTH] < 1.0


@pytest.mark.parametrize("row", ["two_stage_wifi_alone", "two_stage_mems_alone"])
def test_fused_is_better_than_either_alone(row: str) -> None:
    errors: list[list[float]] = [[], []]
    for seed in (1, 2, 4, 5, 6, 7):
        walk = walked(seed, length_m=150.0)
        for found, method in zip(errors, (TWO_STAGE_EKF, ALONE[row]), strict=True):
            found += errors_m(walk, run(method, walk.batches)).tolist()
    assert np.mean(errors[0]) < np.mean(errors[1])


def test_the_papers_noise_leans_on_the_steps_and_says_so() -> None:
    ours, paper = (run(method, WALK.batches) for method in (TWO_STAGE_EKF, ALONE["two_stage_ekf_paper_noise"]))
    radius = [np.mean([fix.accuracy_m for fix in fixes if fix.accuracy_m is not None]) for fixes in (ours, paper)]
    assert radius[1] > radius[0]
    checks = [check for fix in paper for check in fix.checks]
    assert checks and not any(check.rejected for check in checks)


def test_a_phone_without_compass_finds_north_from_its_fixes() -> None:
    walk = walked(1, length_m=150.0)
    batches = [without(batch, "rotation_vector", "magnetometer") for batch in walk.batches]
    fixes = run(TWO_STAGE_EKF, batches)
    assert fixes[3].heading_rad is None
    off = []
    for fix, batch in zip(fixes, batches, strict=True):
        if fix.heading_rad is not None and batch.end_s is not None:
            way = walk.truth(batch.end_s + 0.5) - walk.truth(batch.end_s - 0.5)
            if np.hypot(*way) > 0.5:
                off.append(abs(math.remainder(fix.heading_rad - math.atan2(way[0], way[1]), math.tau)))
    assert len(off) > 30 and np.median(off) < math.radians(35.0)


def test_settings_are_the_methods_own() -> None:
    few = two_stage_ekf("few", replace(OURS, least_known=10_000))
    assert all(fix.position is None for fix in run(few, WALK.batches[:20]))
