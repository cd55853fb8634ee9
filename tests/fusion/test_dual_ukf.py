"""What method C adds: phones anywhere on the body, noises of each step and scan, and a trusted area."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from app.estimation.arrays import FloatArray
from app.evaluation.alone import ALONE
from app.evaluation.truth import batches_of
from app.fusion import walking_ukf as ukf
from app.fusion.carried_position import area_match, moved_on
from app.fusion.carried_steps import Carried, CarriedStep, reversed_by, turned_round
from app.fusion.dual_settings import AS_PRINTED, DualSettings, Empirical, Filter, TrustedArea
from app.fusion.dual_ukf import DUAL_UKF, dual_ukf
from app.fusion.heading_search import HeadingSearch
from app.fusion.walking_track import Track, TrackSettings, begun, headed
from app.observations import Carrying, Step
from app.pdr.rmpca import Direction
from app.simulation.carrying import Bearing, feel_carried
from app.simulation.recording import SURVEY_PHONE, Recording
from app.simulation.trace_writer import trace_bytes
from app.simulation.walker import Person, walk_route
from app.simulation.wifi_scanner import scans_along
from app.survey.trace import read_trace
from tests.fusion.walks import RATE_HZ, START_S, Walked, errors_m, run, site, walked, world

PLAIN = TrackSettings(learning=False)


@lru_cache
def carried(position: Carrying, seed: int) -> Walked:
    """A walk with the phone elsewhere than in the hand; without Android's rotation vector."""
    rng = np.random.default_rng([17, seed])
    floor = world().building.floors[0]
    walk = walk_route(floor, floor.route(rng, 120.0), Person.draw(rng), START_S, RATE_HZ, rng)
    felt = feel_carried(walk, position, Bearing.draw(rng), world().disturbance, rng)
    phone = replace(SURVEY_PHONE, has_rotation_vector=False)
    recording = Recording(phone, walk, felt, scans_along(walk, world().access_points, 0.0, rng))
    trace = read_trace(trace_bytes(recording, world().access_points, "office"), "walk.txt")
    return Walked(trace, tuple(batches_of(trace)))


@pytest.mark.parametrize("position", [Carrying.POCKET, Carrying.CALL, Carrying.SWINGING])
def test_a_phone_that_is_not_looked_at_is_followed_and_its_place_is_told(position: Carrying) -> None:
    errors, told = [], []
    for seed in range(4):
        walk = carried(position, seed)
        fixes = [fix for fix in run(DUAL_UKF, walk.batches) if fix.position is not None]
        errors += errors_m(walk, fixes).tolist()
        told += [fix.carrying for fix in fixes[10:]]
    assert np.mean(errors) < 4.0
    assert told.count(position) > 0.6 * len(told)


def track_at(heading_rad: float, sigma_rad: float, settings: TrackSettings = PLAIN) -> Track:
    begin = begun(np.array([3.0, 4.0]), np.eye(2), 0.0, START_S, settings)
    return headed(begin, heading_rad, sigma_rad)


def one_step(length_m: float = 0.7, sigma_m: float = 0.1, heading_variance: float = 0.04) -> CarriedStep:
    step = Step(START_S + 0.5, 0.5, length_m, 0.9, 0.2, 0.0, math.nan)
    return CarriedStep(step, sigma_m, heading_variance, True)


def test_the_position_after_a_step_agrees_with_many_random_steps() -> None:
    rng = np.random.default_rng(4)
    heading, length = rng.normal(0.9, 0.6, 200_000), 0.7
    ends = np.array([3.0, 4.0]) + rng.normal(0.0, 1.0, (200_000, 2)) + rng.normal(0.0, 0.1, (200_000, 2))
    ends += length * np.column_stack([np.sin(heading), np.cos(heading)])
    after = moved_on(track_at(0.9, 0.6), one_step(), DualSettings(track=replace(PLAIN, alpha=1.0)))
    assert after.mean[:2] == pytest.approx(ends.mean(axis=0), abs=0.02)
    assert after.covariance[:2, :2] == pytest.approx(np.cov(ends.T), abs=0.03)


def test_a_doubtful_heading_is_doubt_across_the_way() -> None:
    north = moved_on(track_at(0.0, 0.3), one_step(heading_variance=0.09), DualSettings(track=PLAIN))
    grown = np.diag(north.covariance)[:2] - 1.0
    assert grown[0] > 3.0 * grown[1]


@pytest.mark.parametrize("learning", [False, True])
def test_for_a_nearly_certain_heading_the_extended_filter_moves_as_the_unscented_one(learning: bool) -> None:
    settings = DualSettings(track=TrackSettings(learning=learning))
    before = track_at(0.9, 0.02, settings.track)
    if learning:
        covariance = before.covariance.copy()
        covariance[ukf.ASKEW, :] = covariance[:, ukf.ASKEW] = 0.0
        covariance[ukf.LOG_SCALE, ukf.LOG_SCALE] = 1e-4
        covariance[ukf.HEADING, ukf.HEADING] = 4e-4
        before = replace(before, covariance=covariance)
    one, other = (
        moved_on(before, one_step(), replace(settings, position_filter=kind))
        for kind in (Filter.UNSCENTED, Filter.EXTENDED)
    )
    assert one.mean == pytest.approx(other.mean, abs=1e-3)
    assert one.covariance == pytest.approx(other.covariance, abs=1e-3)


def test_the_linear_filter_takes_the_heading_for_certain_and_its_noise_for_the_same_in_all_directions() -> None:
    constant = DualSettings(track=PLAIN, empirical=Empirical(), position_filter=Filter.LINEAR)
    after = moved_on(track_at(0.9, 0.3), one_step(), constant)
    assert after.mean[:2] == pytest.approx([3.0 + 0.7 * math.sin(0.9), 4.0 + 0.7 * math.cos(0.9)])
    assert after.covariance[0, 0] == pytest.approx(after.covariance[1, 1])
    assert after.covariance[0, 1] == pytest.approx(0.0, abs=1e-12)


def test_empirical_noises_do_not_listen_to_the_step() -> None:
    constant = DualSettings(track=PLAIN, empirical=Empirical())
    sure, unsure = one_step(sigma_m=0.01, heading_variance=0.001), one_step(sigma_m=0.3, heading_variance=0.16)
    after = [
        moved_on(track_at(0.9, math.sqrt(one.heading_variance)), one, constant).covariance for one in (sure, unsure)
    ]
    assert after[0] == pytest.approx(after[1])


def uncertain(xy_m: FloatArray, sigma_m: float) -> Track:
    return begun(xy_m, sigma_m**2 * np.eye(2), 0.0, START_S, PLAIN)


def test_only_points_near_the_track_take_part_and_the_area_grows_with_doubt() -> None:
    walk = walked(5)
    batch = next(batch for batch in walk.batches[30:] if batch.wifi)
    scan, radio_map = batch.wifi[0], site().radio_map
    assert radio_map is not None and batch.end_s is not None
    truth = walk.truth(batch.end_s)
    literal = DualSettings(area=TrustedArea(least_m=4.0, sigmas=2.0, elsewhere=math.inf))
    far = truth + [25.0, 0.0] if truth[0] < 30.0 else truth - [25.0, 0.0]
    reach = []
    for sigma_m in (1.0, 4.0, 12.0):
        match = area_match(radio_map, scan, "F1", uncertain(far, sigma_m), literal)
        assert match is not None
        apart_m = np.hypot(*(radio_map.xy_m[match.points] - far).T)
        assert apart_m.max() <= 4.0 + 2.0 * sigma_m
        reach.append(float(np.hypot(*(match.xy_m - truth))))
    assert reach[0] > 15.0  # the paper's filter sees nothing but its own surroundings
    assert reach[2] < 8.0
    noticing = area_match(radio_map, scan, "F1", uncertain(far, 1.0), DualSettings(area=TrustedArea(4.0, 2.0, 1.25)))
    assert noticing is not None and np.hypot(*(noticing.xy_m - truth)) < 8.0


def test_a_way_that_was_taken_for_its_opposite_is_turned_round() -> None:
    search = HeadingSearch(np.array([0.0, 15.0]), 0.1, np.zeros(2))
    assert reversed_by(search, 0.1 + math.pi, True)
    assert not reversed_by(search, 1.2, True)
    assert reversed_by(search, 1.9, False) and not reversed_by(search, 1.9, True)
    before = Carried(direction=Direction(np.eye(3), np.array([0.3, 0.4]), 0.0, 1.0))
    after = turned_round(before).direction
    assert after.heading_rad == pytest.approx(1.0 - math.pi)
    assert after.forward == pytest.approx([-0.3, -0.4])


def test_as_printed_it_still_runs_and_its_radii_are_too_small() -> None:
    """The paper's covariances leave out what lasts from scan to scan; that is why ours do not."""
    walk = walked(4)
    inside = []
    for method in (dual_ukf("as_printed", AS_PRINTED), DUAL_UKF):
        fixes = [fix for fix in run(method, walk.batches) if fix.position is not None]
        errors = errors_m(walk, fixes)
        inside.append(np.mean([error <= (fix.accuracy_m or 0.0) for error, fix in zip(errors, fixes, strict=True)]))
    assert inside[0] < inside[1]


def test_the_papers_comparisons_are_rows_of_their_own() -> None:
    rows = {"dual_ukf_empirical", "dual_ekf_empirical", "dual_kf_empirical", "dual_pdr_alone", "dual_wifi_alone"}
    assert rows <= set(ALONE)
