"""What method A learns of a session, and how its phases show."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.fusion import walking_ukf as ukf
from app.fusion.integrity_settings import IntegritySettings
from app.fusion.integrity_ukf import INTEGRITY_UKF, integrity_ukf, start
from app.fusion.interface import SessionStart
from app.integrity.fault_detection import MonitorSettings
from app.observations import AxisSamples, Batch, Flag, Position, WifiScan
from tests.fusion.walks import errors_m, run, site, walked, without

WALK = walked(1, length_m=120.0)
OURS = IntegritySettings()


def turned(batch: Batch, angle_rad: float) -> Batch:
    """The batch of a phone that lies flat but points so much further clockwise than its walker goes."""
    turn = Rotation.from_euler("z", angle_rad)
    streams = {}
    for name in ("accelerometer", "gyroscope", "magnetometer"):
        samples: AxisSamples = getattr(batch, name)
        values = turn.apply(samples.values) if len(samples.values) else samples.values
        streams[name] = AxisSamples(samples.time_s, values)
    return replace(without(batch, "rotation_vector"), **streams)  # type: ignore[arg-type]


@pytest.mark.parametrize("degrees", [-35.0, 35.0])
def test_the_angle_between_phone_and_walking_direction_is_learnt(degrees: float) -> None:
    batches = [turned(batch, math.radians(degrees)) for batch in WALK.batches]
    state = start(SessionStart())
    fixes = []
    for batch in batches:
        state, fix = INTEGRITY_UKF.advance(state, batch, site())
        fixes.append(fix)
    assert state.track is not None
    assert math.degrees(state.track.mean[ukf.ASKEW]) == pytest.approx(degrees, abs=20.0)
    assert errors_m(WALK, fixes)[-40:].mean() < 4.0


@pytest.mark.parametrize("factor", [0.8, 1.25])
def test_the_length_of_a_walkers_steps_is_learnt(factor: float) -> None:
    """Shaken harder by the fourth power, the same steps look longer by the factor."""
    walks = [walked(seed, length_m=200.0) for seed in (1, 2, 4)]
    learnt = []
    for walk in walks:
        scales = []
        for strength in (1.0, factor**4):
            state = start(SessionStart())
            for batch in walk.batches:
                level = np.array([0.0, 0.0, 9.81])
                force = (batch.accelerometer.values - level) * strength + level
                shaken = replace(batch, accelerometer=AxisSamples(batch.accelerometer.time_s, force))
                state, _ = INTEGRITY_UKF.advance(state, shaken, site())
            assert state.track is not None
            scales.append(float(state.track.mean[ukf.LOG_SCALE]))
        learnt.append(scales[1] - scales[0])
    assert np.sign(np.mean(learnt)) == -np.sign(math.log(factor))
    assert abs(np.mean(learnt)) > 0.3 * abs(math.log(factor))


def test_a_phone_without_compass_finds_north_from_its_fixes() -> None:
    batches = [without(batch, "rotation_vector", "magnetometer") for batch in WALK.batches]
    fixes = run(INTEGRITY_UKF, batches)
    assert fixes[3].heading_rad is None
    known = [(fix, batch) for fix, batch in zip(fixes, batches, strict=True) if fix.heading_rad is not None]
    assert len(known) > 30
    off = []
    for fix, batch in known[5:]:
        assert batch.end_s is not None and fix.heading_rad is not None
        way = WALK.truth(batch.end_s + 0.5) - WALK.truth(batch.end_s - 0.5)
        if np.hypot(*way) > 0.5:
            off.append(math.remainder(fix.heading_rad - math.atan2(way[0], way[1]), math.tau))
    assert np.median(np.abs(off)) < math.radians(30.0)


def test_an_accelerometer_alone_never_pretends_to_know_a_heading() -> None:
    batches = [without(batch, "rotation_vector", "magnetometer", "gyroscope") for batch in WALK.batches]
    assert {fix.heading_rad for fix in run(INTEGRITY_UKF, batches)} == {None}


def far_scans(count: int) -> list[Batch]:
    """The walk with so many scans in a row, from its 40th second on, as they sound at the other end of the floor."""
    elsewhere = next(scan for batch in reversed(walked(5).batches) for scan in batch.wifi)
    batches, left = list(WALK.batches), count
    for number, batch in enumerate(batches):
        if number > 40 and batch.wifi and left:
            scan = batch.wifi[0]
            seen_s = elsewhere.seen_s + scan.time_s - elsewhere.time_s
            batches[number] = replace(batch, wifi=(WifiScan(scan.time_s, elsewhere.bssid, elsewhere.rssi_dbm, seen_s),))
            left -= 1
    return batches


def test_two_failed_scans_are_outliers_and_three_a_fault() -> None:
    two = {fix.integrity.flag for fix in run(INTEGRITY_UKF, far_scans(2))[40:]}
    three = {fix.integrity.flag for fix in run(INTEGRITY_UKF, far_scans(3))[40:]}
    assert Flag.OUTLIER in two and Flag.FAULT not in two
    assert Flag.FAULT in three


def test_three_wrong_scans_that_contradict_each_other_are_a_fault_but_do_not_move_the_track() -> None:
    batches = list(WALK.batches)
    one = next(scan for batch in reversed(walked(5).batches) for scan in batch.wifi)
    two = next(scan for batch in walked(4).batches for scan in batch.wifi)
    wrong = [one, two, one]
    for number, batch in enumerate(batches):
        if number > 40 and batch.wifi and wrong:
            scan, other = batch.wifi[0], wrong.pop(0)
            seen_s = other.seen_s + scan.time_s - other.time_s
            batches[number] = replace(batch, wifi=(WifiScan(scan.time_s, other.bssid, other.rssi_dbm, seen_s),))
    fixes = run(INTEGRITY_UKF, batches)
    flags = [fix.integrity.flag for fix in fixes]
    assert Flag.FAULT in flags
    assert errors_m(WALK, fixes)[20:].max() < 6.0
    assert flags[-1] is Flag.NOMINAL


def test_the_plain_filter_never_flags_and_follows_every_scan() -> None:
    plain = integrity_ukf("plain", replace(OURS, monitor=MonitorSettings(monitored=False)))
    followed, watched = run(plain, far_scans(2)), run(INTEGRITY_UKF, far_scans(2))
    assert {fix.integrity.flag for fix in followed[5:]} <= {Flag.NOMINAL, Flag.COASTING}
    assert not any(fix.integrity.if1 for fix in followed)
    assert errors_m(WALK, followed).max() > errors_m(WALK, watched).max() + 5.0


def test_read_literally_the_third_phase_never_finds_an_outlier() -> None:
    literal = integrity_ukf("literal", replace(OURS, monitor=MonitorSettings(literal_phase3=True)))
    fixes = run(literal, far_scans(6))
    assert Flag.CORRECTED in {fix.integrity.flag for fix in fixes}
    assert not any(fix.integrity.if2 or fix.integrity.if3 for fix in fixes)


def test_using_the_control_as_observation_claims_more_than_it_knows() -> None:
    twice = integrity_ukf("twice", replace(OURS, control_twice=True))
    once_m, twice_m = (
        np.mean([fix.accuracy_m for fix in run(method, WALK.batches) if fix.accuracy_m])
        for method in (INTEGRITY_UKF, twice)
    )
    assert twice_m < 0.9 * once_m


def test_while_sources_disagree_the_protection_level_covers_both() -> None:
    fixes = run(INTEGRITY_UKF, far_scans(1))
    flagged = next(fix for fix in fixes if fix.integrity.flag is Flag.OUTLIER)
    before = fixes[fixes.index(flagged) - 1].integrity.protection_level_m
    assert flagged.integrity.protection_level_m is not None and before is not None
    assert flagged.integrity.protection_level_m > before + 15.0


def test_a_start_on_another_floor_gives_way_to_the_first_scan() -> None:
    x_m, y_m = WALK.truth(0.0)
    fixes = run(INTEGRITY_UKF, WALK.batches[:10], start=SessionStart(start=Position(x_m + 40.0, y_m, "F2")))
    first = next(fix for fix in fixes if fix.position is not None)
    assert first.position is not None
    assert first.position.floor == "F1"
    assert errors_m(WALK, [first])[0] < 12.0
