"""The position filter against differences and against the linear filter."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.estimation.arrays import FloatArray
from app.fusion import position_ekf as ekf
from app.fusion.position_ekf import StepTrack
from app.fusion.two_stage_settings import PositionNoise
from app.fusion.unseen import BLIND_M2_PER_S, DOUBTFUL_M2_PER_S
from app.observations import Carrying, Motion
from app.pdr.tracker import PdrOutput

STILL = PositionNoise(0.0, 0.0, 0.0)
NOISE = PositionNoise()
HEADINGS, TURNS = st.floats(-3.0, 3.0), st.floats(-1.0, 1.0)


def track(heading: float, length_m: float = 0.7) -> StepTrack:
    begun = ekf.begun(np.array([4.0, 5.0]), 3.0, 0.0, NOISE)
    known = ekf.headed(begun, heading, 0.2)
    mean = known.mean.copy()
    mean[ekf.LENGTH] = length_m
    return replace(known, mean=mean)


def moved(pending: float = 0.0, until_s: float | None = 10.0, still_s: float | None = None) -> PdrOutput:
    return PdrOutput((), Motion.WALKING, Carrying.HANDHELD, pending, still_s, until_s)


def columns(function: object, at: FloatArray) -> FloatArray:
    return np.column_stack([(function(at + 1e-6 * unit) - function(at - 1e-6 * unit)) / 2e-6 for unit in np.eye(4)])  # type: ignore[operator]


@given(heading=HEADINGS, turn=TURNS)
def test_a_steps_covariance_is_that_of_differences(heading: float, turn: float) -> None:
    before = track(heading)

    def after(mean: FloatArray) -> FloatArray:
        found = ekf.stepped(replace(before, mean=mean), turn, STILL).mean.copy()
        found[ekf.HEADING] = heading + math.remainder(found[ekf.HEADING] - heading, math.tau)
        return found

    jacobian = columns(after, before.mean)
    found = ekf.stepped(before, turn, STILL).covariance
    assert found == pytest.approx(jacobian @ before.covariance @ jacobian.T, abs=1e-6)


@given(heading=HEADINGS, pending=st.floats(0.0, 1.0))
def test_the_place_now_and_its_jacobian_agree(heading: float, pending: float) -> None:
    before = track(heading)

    def place(mean: FloatArray) -> FloatArray:
        return ekf.place(replace(before, mean=mean), moved(pending))[0]

    assert ekf.place(before, moved(pending))[1] == pytest.approx(columns(place, before.mean), abs=1e-6)


def test_a_step_goes_its_length_along_the_heading_in_its_middle() -> None:
    after = ekf.stepped(track(0.0), math.pi / 2.0, STILL)
    assert after.mean[:2] - [4.0, 5.0] == pytest.approx([0.7 * math.sqrt(0.5)] * 2)
    assert after.mean[ekf.HEADING] == pytest.approx(math.pi / 2.0)


def test_a_step_in_an_unknown_direction_widens_the_place_and_moves_nothing() -> None:
    before = ekf.begun(np.array([4.0, 5.0]), 3.0, 0.0, NOISE)
    after = ekf.stepped(before, 0.3, NOISE)
    assert after.mean[:2].tolist() == [4.0, 5.0]
    assert np.diag(after.covariance)[:2] == pytest.approx([3.0 + NOISE.place_m2 + ekf.LOST_SHARE * 0.36] * 2)


def test_fixes_of_a_known_place_are_averaged_as_the_linear_filter_does() -> None:
    found = track(0.4)
    mean, variance = np.array([4.0, 5.0]), 3.0
    for fix in ([9.0, 1.0], [2.0, 8.0], [6.0, 6.0]):
        xy_m, jacobian = ekf.place(found, moved())
        found = ekf.measured(found, np.array(fix) - xy_m, jacobian, 20.0 * np.eye(2))
        mean = mean + variance / (variance + 20.0) * (np.array(fix) - mean)
        variance = variance * 20.0 / (variance + 20.0)
    assert found.mean[:2] == pytest.approx(mean)
    assert np.diag(found.covariance)[:2] == pytest.approx([variance] * 2)


def test_the_place_of_a_walk_on_noise_is_as_uncertain_as_the_filter_says() -> None:
    rng, squares = np.random.default_rng(8), []
    for _ in range(120):
        truth, found = np.array([0.0, 0.0, 0.65, rng.normal(0.3, 0.2)]), track(0.3, 0.65)
        truth[:2] = found.mean[:2] + rng.normal(0.0, math.sqrt(3.0), 2)
        for number in range(40):
            along = truth[3]
            truth[:2] += 0.65 * np.array([math.sin(along), math.cos(along)]) + rng.normal(0.0, 0.2, 2)
            truth[3] += rng.normal(0.0, math.sqrt(NOISE.heading_rad2))
            found = ekf.stepped(found, 0.0, NOISE)
            heard_m = np.array([0.65 + rng.normal(0.0, 0.1) - found.mean[ekf.LENGTH]])
            found = ekf.measured(found, heard_m, ekf.of(ekf.LENGTH), np.array([[NOISE.fix_length_m2]]))
            if number % 4 == 3:
                fix = truth[:2] + rng.normal(0.0, math.sqrt(NOISE.fix_m2), 2)
                found = ekf.measured(found, fix - found.mean[:2], np.eye(4)[:2].copy(), NOISE.fix_m2 * np.eye(2))
        apart = truth[:2] - found.mean[:2]
        squares.append(float(apart @ np.linalg.solve(found.covariance[:2, :2], apart)))
    assert 1.2 < np.mean(squares) < 2.6


@pytest.mark.parametrize(
    ("says", "growth"),
    [
        (moved(until_s=None), BLIND_M2_PER_S),
        (moved(until_s=5.0), BLIND_M2_PER_S),
        (moved(), DOUBTFUL_M2_PER_S),
        (moved(still_s=2.0), 0.0),
        (moved(pending=0.5), 0.0),
    ],
    ids=["no sensor", "silent sensor", "shaken", "still", "between steps"],
)
def test_time_widens_the_place_by_what_is_not_known_of_it(says: PdrOutput, growth: float) -> None:
    before = track(0.0)
    after = ekf.aged(before, 10.0, says)
    assert np.diag(after.covariance)[:2] == pytest.approx(np.diag(before.covariance)[:2] + 10.0 * growth)
    assert after.time_s == 10.0
    assert ekf.aged(after, 9.0, says) is after
