"""What of method D is its own: the error state, the noise by context, and the F test."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from app.estimation.arrays import FloatArray
from app.estimation.error_state_kalman import error_after
from app.evaluation.alone import ALONE
from app.floorplan.openness import Surroundings
from app.fusion.adaptive_robust_kf import ADAPTIVE_ROBUST_KF, start
from app.fusion.adaptive_robust_settings import PAPER_NOISE, STEPS_A_SCAN, AdaptiveRobustSettings
from app.fusion.error_track import ErrorTrack, begun, headed, put_right, stepped
from app.fusion.interface import SessionStart
from app.fusion.robust_measuring import process_noise, robust_update
from app.observations import Carrying, Flag, Motion, Step, WifiScan
from app.pdr.tracker import PdrOutput
from app.pdr.walking_context import WalkingContext
from tests.fusion.walks import errors_m, run, site, walked

OURS = AdaptiveRobustSettings()
STANDING = PdrOutput((), Motion.STILL, Carrying.UNKNOWN, 0.0, 0.0, 0.0)
EAST = Step(0.0, 0.5, 0.7, math.pi / 2.0, 0.1, 0.0, math.nan)
NO_NOISE = np.zeros(4)


def track_at(x_m: float, y_m: float, sigma_m: float = 2.0) -> ErrorTrack:
    track = begun(np.array([x_m, y_m]), sigma_m**2 * np.eye(2), 0.0, OURS)
    return replace(headed(track, 0.0, 0.1), absolute=True)


def test_the_transition_of_the_error_is_the_derivative_of_the_step() -> None:
    """Eq. 9 against differences: a nominal track that is wrong by a little is wrong by F times that after a step."""
    wrong = 1e-6
    step = replace(EAST, heading_rad=0.9)
    moved = stepped(track_at(3.0, 4.0), step, 0.7, True, NO_NOISE, OURS)
    transition = np.empty((4, 4))
    for k in range(4):
        off = put_right(track_at(3.0, 4.0), wrong * np.eye(4)[k], np.zeros((4, 4)))
        after = stepped(off, step, 0.7, True, NO_NOISE, OURS)
        difference = [
            *(after.xy_m - moved.xy_m),
            after.length_m - moved.length_m,
            after.heading_rad - moved.heading_rad,
        ]
        transition[:, k] = np.array(difference) / wrong
    before = track_at(3.0, 4.0).covariance
    assert moved.covariance == pytest.approx(transition @ before @ transition.T, abs=1e-5)


def test_what_the_filter_finds_wrong_is_put_right_in_every_later_step() -> None:
    track = put_right(track_at(0.0, 0.0), np.array([1.0, -1.0, 0.1, -math.pi / 2.0]), np.eye(4))
    track = stepped(track, EAST, 0.7, True, NO_NOISE, OURS)
    assert track.xy_m == pytest.approx([1.0, -1.0 + 0.8])
    assert track.direction_rad == pytest.approx(0.0)


def test_a_fix_that_passes_the_test_is_fused_as_the_plain_filter_does() -> None:
    fix_m = np.array([3.0, -2.0])
    plain, robust = (
        robust_update(track_at(0.0, 0.0), 1.0, fix_m, 9.0, STANDING, settings)
        for settings in (replace(OURS, robust=False), OURS)
    )
    assert robust.phases.if1 == 0
    assert np.array_equal(robust.track.xy_m, plain.track.xy_m)


def test_a_fix_that_fails_is_fused_with_its_noise_inflated_by_beta() -> None:
    """Eq. 18-21 by hand: S = 4 + 9, lambda = r^2 / (2 S), beta = lambda / 4.605."""
    fix_m = np.array([20.0, 0.0])
    updated = robust_update(track_at(0.0, 0.0), 1.0, fix_m, 9.0, STANDING, OURS)
    statistic = 20.0**2 / (4.0 + 9.0) / 2.0
    assert updated.phases.threshold == pytest.approx(4.605, abs=1e-3)
    assert updated.phases.statistic == pytest.approx(statistic)
    beta = statistic / -math.log(0.01)
    assert updated.track.xy_m == pytest.approx([20.0 * 4.0 / (4.0 + 9.0 * beta), 0.0])
    assert (updated.phases.if1, updated.phases.if2) == (1, 1)
    assert updated.check.rejected and not updated.check.fused


def test_the_farther_the_fix_the_less_of_it_is_believed() -> None:
    fixes_m = [np.array([apart_m, 0.0]) for apart_m in (15.0, 30.0, 60.0, 1e4)]
    moved_m = [robust_update(track_at(0.0, 0.0), 1.0, fix, 9.0, STANDING, OURS).track.xy_m[0] for fix in fixes_m]
    assert moved_m == sorted(moved_m, reverse=True)
    assert moved_m[-1] < 0.01


def test_a_fix_that_is_no_place_changes_nothing() -> None:
    track = track_at(0.0, 0.0)
    updated = robust_update(track, 1.0, np.array([math.nan, 0.0]), 9.0, STANDING, OURS)
    assert updated.track is track
    assert updated.check.rejected and updated.phases.if2 == 1


@pytest.mark.parametrize("settings", [OURS, replace(OURS, noise=PAPER_NOISE)])
def test_turns_open_areas_and_unusual_paces_are_less_certain(settings: AdaptiveRobustSettings) -> None:
    def noise(
        turn_rad: float = 0.0, speed_mps: float = 1.2, around: Surroundings = Surroundings.CORRIDOR
    ) -> FloatArray:
        return process_noise(WalkingContext((turn_rad,), (speed_mps,)), around, settings)

    usual = noise()
    assert (noise(turn_rad=1.0) > usual).tolist() == [False, False, False, True]
    assert (noise(speed_mps=0.5) > usual).tolist() == [False, False, True, False]
    assert (noise(speed_mps=2.0) > usual).tolist() == [False, False, True, False]
    assert (noise(around=Surroundings.OPEN) > usual).tolist() == [True, True, False, False]
    standard = replace(settings, adaptive=False)
    context = WalkingContext((1.0,), (2.0,))
    assert np.array_equal(
        process_noise(context, Surroundings.OPEN, standard),
        process_noise(WalkingContext(), Surroundings.CORRIDOR, standard),
    )


def test_the_papers_noise_is_spread_over_the_steps_between_two_scans() -> None:
    noise = STEPS_A_SCAN * process_noise(
        WalkingContext((1.0,), (1.2,)), Surroundings.CORRIDOR, replace(OURS, noise=PAPER_NOISE)
    )
    assert np.sqrt(noise) == pytest.approx([2.5, 2.5, 1.0, math.radians(10.0)])


def test_the_error_state_update_equals_the_kalman_filters() -> None:
    track = track_at(1.0, 2.0)
    updated = robust_update(track, 1.0, np.array([3.0, 2.0]), 9.0, STANDING, OURS)
    error, covariance = error_after(track.covariance, np.array([2.0, 0.0]), np.eye(2, 4), 9.0 * np.eye(2))
    assert updated.track.xy_m == pytest.approx(track.xy_m + error[:2])
    assert updated.track.covariance == pytest.approx(covariance)


def test_gross_errors_move_the_robust_filter_less_than_its_ablations() -> None:
    """The paper's second table: the error where single scans are grossly wrong."""
    elsewhere = next(scan for batch in reversed(walked(5).batches) for scan in batch.wifi)
    walk = walked(1, length_m=120.0)
    batches, hit = list(walk.batches), []
    for number in range(30, len(batches), 15):
        if batches[number].wifi:
            scan = batches[number].wifi[0]
            seen_s = elsewhere.seen_s + scan.time_s - elsewhere.time_s
            wrong = WifiScan(scan.time_s, elsewhere.bssid, elsewhere.rssi_dbm, seen_s)
            batches[number] = replace(batches[number], wifi=(wrong,))
            hit.append(number)
    assert len(hit) >= 2
    at_hits: dict[str, float] = {}
    for method in (ADAPTIVE_ROBUST_KF, ALONE["adaptive_robust_kf_adaptive"], ALONE["adaptive_robust_kf_standard"]):
        fixes = run(method, batches)
        at_hits[method.method] = float(np.mean([errors_m(walk, [fixes[number]])[0] for number in hit]))
    assert at_hits["adaptive_robust_kf"] < 0.7 * at_hits["adaptive_robust_kf_adaptive"]
    assert at_hits["adaptive_robust_kf"] < 0.7 * at_hits["adaptive_robust_kf_standard"]


def test_without_the_robust_part_nothing_is_ever_flagged() -> None:
    fixes = run(ALONE["adaptive_robust_kf_adaptive"], walked(1).batches)
    assert {fix.integrity.flag for fix in fixes} <= {Flag.INITIALISING, Flag.NOMINAL, Flag.COASTING}


def test_walking_makes_the_angle_between_phone_and_walking_direction_more_certain() -> None:
    state = start(SessionStart())
    for batch in walked(2, length_m=150.0).batches:
        state, _ = ADAPTIVE_ROBUST_KF.advance(state, batch, site())
    assert state.track is not None
    first_rad, learnt_rad = OURS.askew_sigma_rad, math.sqrt(state.track.covariance[3, 3])
    assert learnt_rad < first_rad
