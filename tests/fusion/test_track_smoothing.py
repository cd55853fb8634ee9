"""Smoothed tracks: better than what was known at the time, by the same evidence however it came."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from app.estimation.arrays import FloatArray
from app.fusion.integrity_measuring import BY_WIFI, after_step, measure
from app.fusion.integrity_settings import IntegritySettings
from app.fusion.methods import METHODS
from app.fusion.smoothed_track import KnownThen, SmoothedTrack
from app.fusion.track_smoothing import smoothed
from app.fusion.walk_timeline import Moment
from app.fusion.walking_track import Track, begun
from app.integrity.protection_level import radius_holding
from app.observations import Motion, RadioFix, Step
from tests.fusion.evidence import STEP_S, Told, told
from tests.fusion.walks import errors_m, run, walked

SEEDS = range(20)


def track_of(walk: Told) -> SmoothedTrack:
    track = smoothed(walk.evidence, walk.moments)
    assert track is not None
    return track


def filtered_m(walk: Told) -> FloatArray:
    """(n, 2) what the forward filter knows after each step and the scan at its end."""
    settings, track, places = IntegritySettings(), None, list[FloatArray]()
    for one in walk.evidence:
        if isinstance(one, Step):
            if track is not None:
                track = after_step(track, one, True, settings, [])
                places.append(track.mean[:2])
        else:
            track = _scanned(track, one, settings)
            places[-1:] = [track.mean[:2]]
    return np.array(places)


def _scanned(track: Track | None, fix: RadioFix, settings: IntegritySettings) -> Track:
    if track is None:
        return begun(fix.xy_m, fix.noise_m2, fix.lasting_m2, fix.time_s, settings.track)
    track = replace(track, bias_variance_m2=fix.lasting_m2)
    before = track.mean[:3]
    after, _ = measure(track, "wifi", fix.time_s, BY_WIFI, fix.xy_m, fix.noise_m2, before, 0.0, settings)
    return replace(track, mean=after.mean, covariance=after.covariance)


@pytest.mark.parametrize("turn_rad", [0.0, 0.04])
def test_a_walk_is_recovered_better_than_by_the_forward_filter(turn_rad: float) -> None:
    walks = [told(seed, turn_rad=turn_rad) for seed in SEEDS]
    forward = [walk.error_m(filtered_m(walk)) for walk in walks]
    backward = [walk.error_m(track_of(walk).xy_m) for walk in walks]
    assert np.mean(backward) < 0.85 * np.mean(forward)


def test_the_beginning_is_as_good_as_the_rest_though_the_phone_did_not_know_north() -> None:
    errors = []
    for seed in SEEDS:
        walk = told(seed, north=False, turn_rad=0.02)
        errors.append(np.hypot(*(track_of(walk).xy_m - walk.truth_m).T))
    mean = np.mean(errors, axis=0)
    assert mean[:20].mean() < 1.3 * mean[30:50].mean()


def test_an_angle_at_which_the_phone_is_held_and_longer_steps_are_learnt() -> None:
    plain = [track_of(walk := told(seed)).xy_m - walk.truth_m for seed in SEEDS]
    other = [track_of(walk := told(seed, scale=1.15, askew_rad=0.4)).xy_m - walk.truth_m for seed in SEEDS]
    assert np.hypot(*np.concatenate(other).T).mean() < 1.4 * np.hypot(*np.concatenate(plain).T).mean()


def test_the_covariance_holds_the_errors_of_the_model() -> None:
    squares = []
    for seed in range(60):
        walk = told(seed, turn_rad=0.03)
        track = track_of(walk)
        error = track.xy_m - walk.truth_m
        squares.append(np.einsum("ni,nij,nj->n", error, np.linalg.inv(track.covariance_m2), error).mean())
    # the covariance is 1.7 times what the model gives: fixes of real places err for longer
    assert 0.7 < np.mean(squares) < 1.7


@pytest.mark.parametrize("fits", [True, False])
def test_scans_from_elsewhere_do_not_drag_the_track(fits: bool) -> None:
    clean, relayed = [], []
    for seed in SEEDS:
        walk = told(seed, steps=120)
        scans = [one for one in walk.evidence if isinstance(one, RadioFix)]
        foreign = {one.time_s for one in scans[10:14]}
        away_m = np.array([60.0, -40.0])
        evidence = tuple(
            replace(one, xy_m=one.xy_m + away_m, fits=fits)
            if isinstance(one, RadioFix) and one.time_s in foreign
            else one
            for one in walk.evidence
        )
        clean.append(walk.error_m(track_of(walk).xy_m))
        relayed.append(walk.error_m(track_of(replace(walk, evidence=evidence)).xy_m))
    assert np.mean(relayed) < 1.25 * np.mean(clean)


def test_while_the_last_scans_are_at_another_place_the_level_reaches_there() -> None:
    walk = told(1)
    last = [one for one in walk.evidence if isinstance(one, RadioFix)][-2:]
    evidence = [one for one in walk.evidence if not any(one is other for other in last)]
    moved = [replace(one, xy_m=one.xy_m + 80.0, fits=False) for one in last]
    track = smoothed([*evidence, *moved], walk.moments)
    assert track is not None and track.contested_s == last[0].time_s
    levels = [level_m(track, index, as_known(track, index)) for index in range(len(walk.moments))]
    before = [level for level, moment in zip(levels, walk.moments, strict=True) if moment.time_s < last[0].time_s]
    assert max(before) < 30.0
    assert levels[-1] > 100.0


def as_known(track: SmoothedTrack, index: int, east_m: float = 0.0, level_m: float = 12.0) -> KnownThen:
    """A Fix of the time so far east of the smoothed place."""
    x_m, y_m = track.xy_m[index].tolist()
    return KnownThen(x_m + east_m, y_m, level_m, 10.0)


def level_m(track: SmoothedTrack, index: int, known: KnownThen) -> float:
    return track.answer(index, 0.01, known).level_m


def test_the_level_reaches_what_was_known_at_the_time_where_the_two_contradict() -> None:
    track = track_of(told(2))
    assert level_m(track, 40, as_known(track, 40)) == level_m(track, 40, as_known(track, 40, 5.0))
    assert level_m(track, 40, as_known(track, 40, 30.0)) == pytest.approx(42.0)
    for spoken_against in (replace(as_known(track, 40, 5.0), if2=1), replace(as_known(track, 40, 5.0), if3=1)):
        assert level_m(track, 40, spoken_against) >= 17.0


@given(st.integers(0, 1000), st.randoms(use_true_random=False), st.booleans())
@settings(max_examples=25)
def test_it_does_not_matter_in_which_order_evidence_came_nor_when_the_track_is_asked_for(
    seed: int, random: object, north: bool
) -> None:
    walk = told(seed, steps=40, turn_rad=0.03, north=north)
    shuffled = list(walk.evidence)
    random.shuffle(shuffled)  # type: ignore[attr-defined]
    fewer = (*walk.moments[3::7], walk.moments[-1])
    kept = [walk.moments.index(moment) for moment in fewer]
    whole, part = track_of(walk), smoothed(shuffled, fewer)
    assert part is not None
    assert np.allclose(part.xy_m, whole.xy_m[kept], atol=1e-6)
    assert np.allclose(part.covariance_m2, whole.covariance_m2[kept], atol=1e-6)


@given(st.integers(0, 1000), st.floats(-500.0, 500.0), st.floats(-math.pi, math.pi))
@example(285, 0.0, 2.5)
@settings(max_examples=25)
def test_moved_evidence_gives_the_moved_track(seed: int, by_m: float, turn_rad: float) -> None:
    walk = told(seed, steps=40, north=False)
    east, north = math.cos(turn_rad), math.sin(turn_rad)
    rotation = np.array([[east, -north], [north, east]])
    moved = [
        replace(one, xy_m=rotation @ one.xy_m + by_m) if isinstance(one, RadioFix) else one for one in walk.evidence
    ]
    track = smoothed(moved, walk.moments)
    assert track is not None
    assert np.allclose(track.xy_m, track_of(walk).xy_m @ rotation.T + by_m, atol=0.1)


def test_a_phone_that_lies_still_for_long_is_one_place() -> None:
    rng = np.random.default_rng(3)
    fixes = [
        RadioFix(float(k), "F1", rng.normal(size=2) * 3.0, 8.0 * np.eye(2), 0.0, 0.1, fits=True) for k in range(100)
    ]
    track = smoothed(fixes, [Moment(float(k), Motion.STILL) for k in range(100)])
    assert track is not None
    assert np.ptp(track.xy_m, axis=0).max() < 0.1
    assert np.hypot(*track.xy_m[50]) < 1.0


def test_a_phone_that_counts_no_steps_goes_where_its_scans_are() -> None:
    fixes = [
        RadioFix(float(k), "F1", np.array([1.2 * k, 0.0]), 4.0 * np.eye(2), 2.0, 0.1, fits=True) for k in range(60)
    ]
    track = smoothed(fixes, [Moment(float(k), Motion.UNKNOWN) for k in range(60)])
    assert track is not None
    assert np.abs(track.xy_m[:, 0] - 1.2 * np.arange(60)).max() < 3.0
    assert np.isnan(track.heading_rad).all()


def test_floors_have_nothing_in_common_but_the_walk() -> None:
    walk, other = told(5, steps=60), told(6, steps=60)
    upstairs = [
        replace(one, time_s=one.time_s + 60 * STEP_S, floor="F2")
        if isinstance(one, RadioFix)
        else replace(one, time_s=one.time_s + 60 * STEP_S)
        for one in other.evidence
    ]
    moments = [*walk.moments, *(replace(moment, time_s=moment.time_s + 60 * STEP_S) for moment in other.moments)]
    track = smoothed([*walk.evidence, *upstairs], moments)
    assert track is not None
    assert track.floor == ["F1"] * 60 + ["F2"] * 60
    assert np.hypot(*(track.xy_m[60:] - other.truth_m).T).mean() < 6.0


def test_without_a_scan_there_is_no_track() -> None:
    assert smoothed([], [Moment(0.0, Motion.STILL)]) is None


def test_one_scan_is_a_track() -> None:
    track = smoothed(
        [RadioFix(5.0, "F1", np.array([3.0, 4.0]), np.eye(2), 3.0, 0.1, fits=True)], [Moment(0.0, Motion.STILL)]
    )
    assert track is not None
    assert np.allclose(track.xy_m, [[3.0, 4.0]])
    assert np.allclose(track.covariance_m2, 1.7 * 4.0 * np.eye(2), rtol=1e-3)


@pytest.mark.parametrize("method", sorted(METHODS))
def test_every_method_leaves_evidence_from_which_its_walk_is_better_known(method: str) -> None:
    before, after = [], []
    for seed in (0, 1, 2, 4, 5):
        walk = walked(seed)
        fixes = run(METHODS[method], walk.batches)
        moments = [Moment(float(fix.time_s or 0.0), fix.motion) for fix in fixes]
        track = smoothed(list(itertools.chain.from_iterable(fix.evidence for fix in fixes)), moments)
        assert track is not None
        placed = [number for number, fix in enumerate(fixes) if fix.position is not None]
        truth = np.array([walk.truth(moments[number].time_s) for number in placed])
        before += errors_m(walk, fixes).tolist()
        after += np.hypot(*(track.xy_m[placed] - truth).T).tolist()
    assert np.mean(after) < np.mean(before)


def test_the_level_of_an_uncertain_floor_stays_beyond_the_alert_limit() -> None:
    track = track_of(told(2))
    certain = as_known(track, 20, level_m=30.0)
    assert level_m(track, 20, certain) == level_m(track, 20, as_known(track, 20)) < 30.0
    assert level_m(track, 20, replace(certain, floor_certain=False)) == 30.0


def test_radii_and_covariance_grow_with_how_unlike_the_survey_scans_were() -> None:
    track = track_of(told(2))
    usual = track.answer(20, 0.01, as_known(track, 20))
    strange = track.answer(20, 0.01, replace(as_known(track, 20), unsurveyed_m2=100.0))
    assert np.allclose(strange.covariance_m2, usual.covariance_m2 + 100.0 * np.eye(2))
    assert strange.accuracy_m == radius_holding(strange.covariance_m2, 0.68) > 15.0
    assert strange.level_m > 36.0 and not strange.usable
    assert strange.xy_m.tolist() == usual.xy_m.tolist()


def test_the_place_lies_between_the_track_and_an_answer_that_knew_walls_unless_they_contradict() -> None:
    track = track_of(told(2))
    walled = replace(as_known(track, 40, 5.0), walls=True)
    assert track.answer(40, 0.01, walled).xy_m == pytest.approx(track.xy_m[40] + [2.0, 0.0])
    for other in (
        replace(walled, walls=False),
        replace(walled, if2=1),
        replace(as_known(track, 40, 12.1), walls=True),
    ):
        assert track.answer(40, 0.01, other).xy_m.tolist() == track.xy_m[40].tolist()
