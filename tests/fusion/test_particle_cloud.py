"""A cloud of particles: what it knows after fixes and steps, and that walls stop it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.estimation.arrays import FloatArray
from app.floorplan.free_space import NO_PLAN, FreeSpace
from app.fusion import cloud_kernels as kernels
from app.fusion.cloud_fusing import expected, fused
from app.fusion.cloud_place import Place, heading_of, place, scale_of
from app.fusion.cloud_settings import CloudSettings
from app.fusion.particle_cloud import Cloud, aged, begun, landed, stepped
from app.fusion.state_codec import decode_state, encode_state
from app.observations import Carrying, Motion, Step
from app.pdr.tracker import PdrOutput
from app.pdr.turn_doubt import LedStep

MANY = CloudSettings(particles=4000)
HERE = np.array([20.0, 5.0])
NORTH_SIGMA_RAD = 0.2


def moved(still: bool = False, until_s: float | None = 0.0) -> PdrOutput:
    motion = Motion.STILL if still else Motion.UNKNOWN
    return PdrOutput((), motion, Carrying.UNKNOWN, 0.0, 0.0 if still else None, until_s)


STANDING = moved(still=True)


def step(heading_rad: float = 0.0, turn_rad: float = 0.0, length_m: float = 0.7, sigma_rad: float = 0.2) -> Step:
    return Step(0.0, 0.5, length_m, heading_rad, sigma_rad, turn_rad, math.nan)


def at(xy_m: FloatArray = HERE, own_m2: float = 4.0, lasting_m2: float = 4.0, space: FreeSpace = NO_PLAN) -> Cloud:
    return begun(xy_m, own_m2, lasting_m2, 0.0, space, MANY)


def walked(cloud: Cloud, steps: int, space: FreeSpace = NO_PLAN, **of_step: float) -> Cloud:
    for _ in range(steps):
        cloud = stepped(cloud, LedStep(step(**of_step)), space, MANY)
    return cloud


def with_fix(cloud: Cloud, xy_m: FloatArray, own_m2: float = 4.0, lasting_m2: float | None = 4.0) -> Cloud:
    return fused(cloud, xy_m, own_m2, lasting_m2, 1.0, STANDING, NO_PLAN, MANY)


def here(cloud: Cloud) -> Place:
    return place(cloud, STANDING)


def corridor(width_m: float = 3.0) -> FreeSpace:
    """East to west along y = 5, in a floor of 40 by 10 m."""
    cells = np.zeros((20, 80), np.bool_)
    cells[round(2 * (5.0 - width_m / 2)) : round(2 * (5.0 + width_m / 2))] = True
    return FreeSpace(cells, 0.5)


def test_a_cloud_begins_around_its_fix_as_wide_as_the_fix_is_uncertain() -> None:
    found = here(at())
    assert found.xy_m == pytest.approx(HERE, abs=0.2)
    assert np.diag(found.covariance_m2) == pytest.approx([8.0, 8.0], rel=0.1)
    assert found.radius_99_m == pytest.approx(math.sqrt(-2.0 * math.log(0.01) * 8.0), rel=0.1)


def test_within_walls_a_cloud_begins_where_one_can_be() -> None:
    cloud = at(np.array([20.0, 7.5]), space=corridor())
    assert all(kernels.is_free(corridor().cells, 0.5, x, y) for x, y in cloud.particles[:, :2].tolist())


def test_a_share_of_the_cloud_begins_at_the_other_places_that_the_scan_is_like() -> None:
    cloud = begun(HERE, 4.0, 4.0, 0.0, NO_PLAN, MANY, elsewhere_m=np.array([[120.0, 5.0]]))
    there = float(np.mean(cloud.particles[:, 0] > 100.0))
    assert there == pytest.approx(MANY.elsewhere, abs=0.02)
    assert here(cloud).xy_m == pytest.approx(HERE, abs=1.0)
    assert here(cloud).radius_99_m > 90.0


def test_steps_lead_where_the_phone_points() -> None:
    found = here(walked(at(), 20, heading_rad=math.pi / 2.0))
    assert found.xy_m[0] - HERE[0] == pytest.approx(20 * 0.7, abs=2.5)
    assert abs(found.xy_m[1] - HERE[1]) < 1.5


def test_a_phone_without_north_goes_nowhere_in_particular_and_says_so() -> None:
    cloud = walked(at(), 1, sigma_rad=math.pi)
    assert heading_of(cloud) is None
    assert here(walked(cloud, 10, sigma_rad=math.pi)).radius_68_m > here(at()).radius_68_m


def test_walls_on_both_sides_tell_the_direction_that_a_phone_without_north_does_not_know() -> None:
    space = corridor(2.0)
    cloud = walked(at(np.array([5.0, 5.0]), 1.0, 1.0, space), 30, space, sigma_rad=math.pi)
    assert here(cloud).xy_m[0] > 12.0
    assert heading_of(cloud) == pytest.approx(math.pi / 2.0, abs=0.4)


@pytest.mark.parametrize(("through", "most"), [(0.0, 0.0), (0.1, 0.2)])
def test_walls_stop_particles_but_for_the_share_that_believes_in_a_door(through: float, most: float) -> None:
    space, cloud = corridor(), at(space=corridor())
    for _ in range(30):
        cloud = stepped(cloud, LedStep(step(math.pi / 2.0)), space, CloudSettings(through=through))
    outside = [not kernels.is_free(space.cells, space.cell_m, x, y) for x, y in cloud.particles[:, :2].tolist()]
    assert np.average(outside, weights=cloud.weight) <= most
    assert any(outside) == (through > 0.0)


def test_a_cloud_in_a_room_that_the_plan_calls_solid_still_moves() -> None:
    solid = FreeSpace(np.zeros((20, 80), np.bool_), 0.5)
    assert here(walked(at(), 20, solid, heading_rad=math.pi / 2.0)).xy_m[0] > HERE[0] + 9.0


def test_fixes_in_one_place_are_no_independent_witnesses() -> None:
    lasting, fresh = at(), at(own_m2=8.0, lasting_m2=1e-6)
    for _ in range(20):
        lasting = with_fix(lasting, HERE)
        fresh = with_fix(fresh, HERE, 8.0, 1e-6)
    assert np.trace(here(lasting).covariance_m2) > 4.0
    assert np.trace(here(fresh).covariance_m2) < 1.5


def test_a_linear_walk_agrees_with_the_kalman_filter() -> None:
    """Known directions and no walls make the model linear: mean and covariance are then known."""
    exact = CloudSettings(
        particles=20_000,
        turn_sigma_rad=0.0,
        scale_sigma=1e-6,
        scale_drift=0.0,
        facing_sigma_rad=0.0,
        astray=0.0,
        renewed=0.0,
        rough_m=0.0,
    )
    cloud = begun(HERE, 6.0, 3.0, 0.0, NO_PLAN, exact)
    # east only: position and lasting error
    mean, covariance = np.array([HERE[0], 0.0]), np.array([[9.0, -3.0], [-3.0, 3.0]])
    seen = np.array([1.0, 1.0])
    for number in range(12):
        cloud = stepped(cloud, LedStep(Step(0.0, 0.5, 0.7, math.pi / 2, 0.0, 0.0, math.nan)), NO_PLAN, exact)
        kept = math.exp(-0.7 / exact.bias_reach_m)
        forth = np.diag([1.0, kept])
        mean = forth @ mean + [0.7, 0.0]
        noise = np.diag([exact.step_sigma_m**2, 3.0 * (1 - kept**2)])
        covariance = forth @ covariance @ forth.T + noise
        if number % 3 == 2:
            fix_m = np.array([HERE[0] + 0.7 * number + 2.0, HERE[1]])
            cloud = fused(cloud, fix_m, 6.0, 3.0, 1.0, STANDING, NO_PLAN, exact)
            spread = seen @ covariance @ seen + 6.0
            gain = covariance @ seen / spread
            mean = mean + gain * (fix_m[0] - seen @ mean)
            covariance = covariance - np.outer(gain, gain) * spread
    found = here(cloud)
    assert found.xy_m[0] == pytest.approx(mean[0], abs=0.15)
    assert found.covariance_m2[0, 0] == pytest.approx(covariance[0, 0], rel=0.1)
    expected_m, spread_m2 = expected(cloud, STANDING)
    assert expected_m[0] == pytest.approx(mean.sum(), abs=0.15)
    assert spread_m2[0, 0] == pytest.approx(seen @ covariance @ seen, rel=0.1)


def test_the_length_of_steps_is_learnt() -> None:
    cloud = walked(at(), 1, heading_rad=math.pi / 2)
    true_m = HERE + [0.84, 0.0]
    for number in range(2, 120):
        cloud = walked(cloud, 1, heading_rad=math.pi / 2)
        true_m = true_m + [0.84, 0.0]  # a fifth longer than the model says
        if number % 3 == 0:
            cloud = with_fix(cloud, true_m, 1.0, 1.0)
    assert scale_of(cloud) == pytest.approx(1.2, abs=0.06)


def test_a_fix_without_wifis_lasting_error_leaves_what_is_known_of_it() -> None:
    cloud = with_fix(at(), HERE, 2.0, None)
    assert cloud.bias_m2 == at().bias_m2
    assert np.trace(here(cloud).covariance_m2) < np.trace(here(at()).covariance_m2)


def test_a_blind_phone_gets_less_certain_with_time_and_one_that_lies_still_does_not() -> None:
    assert aged(at(), 10.0, moved(still=True, until_s=10.0), MANY).unseen_m2 == 0.0
    blind = aged(at(), 10.0, moved(until_s=None), MANY)
    assert here(blind).radius_99_m > 1.5 * here(at()).radius_99_m
    assert blind.bias_m2 > at().bias_m2


def test_on_another_floor_the_place_is_kept_and_the_heading_is_not() -> None:
    arrived = landed(walked(at(), 5), 2.0)
    assert heading_of(arrived) is None
    assert here(arrived).xy_m == pytest.approx(here(walked(at(), 5)).xy_m)
    assert here(arrived).radius_68_m > here(walked(at(), 5)).radius_68_m


@settings(max_examples=30, deadline=None)
@given(
    events=st.lists(
        st.one_of(
            st.tuples(st.just("step"), st.floats(-math.pi, math.pi), st.floats(0.1, 1.5)),
            st.tuples(st.just("fix"), st.floats(-1e4, 1e4), st.floats(-1e4, 1e4)),
        ),
        max_size=25,
    )
)
def test_whatever_comes_the_cloud_stays_finite_and_repeats_itself(events: list[tuple[str, float, float]]) -> None:
    def run() -> Cloud:
        cloud = begun(HERE, 4.0, 4.0, 0.0, corridor(), CloudSettings(particles=100))
        for kind, first, second in events:
            if kind == "step":
                cloud = stepped(cloud, LedStep(step(first, first / 3.0, second)), corridor(), CloudSettings())
            else:
                fix_m = np.array([first, second])
                cloud = fused(cloud, fix_m, 4.0, 4.0, 1.0, STANDING, corridor(), CloudSettings())
        return cloud

    cloud = run()
    assert np.isfinite(cloud.particles).all()
    assert cloud.weight.sum() == pytest.approx(1.0, abs=1e-3)
    np.testing.assert_array_equal(cloud.particles, run().particles)
    restored = decode_state(encode_state(cloud))
    np.testing.assert_array_equal(restored.particles, cloud.particles)
