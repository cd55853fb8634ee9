"""What the default promises beyond what every method owes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.cloud_place import Place
from app.fusion.interface import SessionStart, Site
from app.fusion.surefix import SUREFIX
from app.fusion.surefix_settings import SurefixSettings
from app.fusion.surefix_state import SurefixState, on_next_floor
from app.observations import AxisSamples, Batch, Fix, Flag, Position, WifiScan
from app.wifi.fix_calibration import DEFAULT
from tests.fusion.walks import errors_m, lying, run, site, walked

HOME = walked(5)
ELSEWHERE = walked(7)


def relayed() -> tuple[list[Batch], int]:
    """A walk whose scans, from its middle on, are those that somebody else heard far away; and the batch it begins."""
    begin = len(HOME.batches) // 2
    here = HOME.truth(HOME.batches[begin].end_s or 0.0)
    scans = [scan for batch in ELSEWHERE.batches for scan in batch.wifi]
    far = [scan for scan in scans if math.dist(ELSEWHERE.truth(scan.time_s), here) > 25.0]
    assert len(far) > 10
    batches, at = list(HOME.batches[:begin]), 0
    for batch in HOME.batches[begin:]:
        false = []
        for scan in batch.wifi:
            heard = far[at % len(far)]
            false.append(WifiScan(scan.time_s, heard.bssid, heard.rssi_dbm, np.full(len(heard.bssid), scan.time_s)))
            at += 1
        batches.append(replace(batch, wifi=tuple(false)))
    return batches, begin


def flags(fixes: list[Fix]) -> list[Flag]:
    return [fix.integrity.flag for fix in fixes]


def test_relayed_scans_raise_an_alarm_within_six_seconds_and_no_answer_is_usable_meanwhile() -> None:
    batches, begin = relayed()
    fixes = run(SUREFIX, batches)
    first = next(n for n in range(begin, len(batches)) if batches[n].wifi)
    assert Flag.FAULT in flags(fixes[first : first + 7])
    alarm = flags(fixes).index(Flag.FAULT)
    assert not any(fix.integrity.usable for fix in fixes[alarm : alarm + 15])


def test_while_two_places_are_possible_the_protection_level_reaches_both() -> None:
    batches, _ = relayed()
    fixes = run(SUREFIX, batches)
    in_fault = [fix for fix in fixes if fix.integrity.flag is Flag.FAULT]
    assert all((fix.integrity.protection_level_m or 0.0) > 15.0 for fix in in_fault)


def test_a_clean_walk_raises_no_alarm_and_is_mostly_nominal() -> None:
    for seed in (5, 6, 7):
        found = flags(run(SUREFIX, list(walked(seed).batches)))
        assert Flag.FAULT not in found
        assert found.count(Flag.NOMINAL) > 0.8 * (len(found) - found.count(Flag.INITIALISING))


def test_access_points_on_the_watch_list_are_as_if_they_were_not_there() -> None:
    known = site()
    assert known.radio_map is not None
    loud = {int(bssid) for batch in HOME.batches for scan in batch.wifi for bssid in scan.bssid[:5]}
    silent = [replace(batch, wifi=tuple(_without(scan, loud) for scan in batch.wifi)) for batch in HOME.batches]
    watched = Site(known.floors, known.radio_map, frozenset(loud))
    left_out = run(SUREFIX, list(HOME.batches), watched)
    assert [fix.position for fix in left_out] == [fix.position for fix in run(SUREFIX, silent, watched)]


def test_a_map_of_another_building_gives_no_position() -> None:
    strange = [replace(batch, wifi=tuple(_moved_away(scan) for scan in batch.wifi)) for batch in HOME.batches]
    assert all(fix.position is None for fix in run(SUREFIX, strange))


def test_a_wrong_start_is_given_up_through_a_fault_as_soon_as_two_scans_contradict_it() -> None:
    batches = list(HOME.batches)
    here = HOME.truth(batches[0].end_s or 0.0)
    wrong = SessionStart(start=Position(float(here[0]) + 30.0, float(here[1]), "F1"))
    fixes = run(SUREFIX, batches, start=wrong)
    scans = [n for n, batch in enumerate(batches) if batch.wifi]
    assert Flag.FAULT in flags(fixes[: scans[2]])
    assert not any(fix.integrity.usable for fix in fixes[: scans[1]])
    assert float(np.mean(errors_m(HOME, fixes[scans[2] :]))) < 4.0
    assert flags(fixes)[-1] is Flag.NOMINAL


def test_a_wrong_start_does_not_bind_a_phone_that_stands_still() -> None:
    here = HOME.truth(HOME.batches[0].end_s or 0.0)
    scan = next(scan for batch in HOME.batches for scan in batch.wifi)
    again = [replace(scan, time_s=scan.time_s + late_s, seen_s=scan.seen_s + late_s) for late_s in range(0, 36, 3)]
    standing = [Batch(number, one.time_s, wifi=(one,)) for number, one in enumerate(again)]
    wrong = SessionStart(start=Position(float(here[0]) + 40.0, float(here[1]), "F1"))
    found = flags(run(SUREFIX, standing, start=wrong))
    assert Flag.FAULT in found and set(found[-4:]) == {Flag.NOMINAL}


def test_a_start_on_another_floor_is_given_up_with_the_first_scan_that_says_so() -> None:
    here = HOME.truth(HOME.batches[0].end_s or 0.0)
    state = SUREFIX.start(SessionStart(start=Position(float(here[0]) + 30.0, float(here[1]), "F2")))
    first = next(n for n, batch in enumerate(HOME.batches) if batch.wifi)
    for batch in HOME.batches[: first + 1]:
        state, fix = SUREFIX.advance(state, batch, site())
    assert isinstance(state, SurefixState) and not state.prior_only
    assert fix.position is not None and fix.position.floor == "F1"


def test_on_the_next_floor_neither_account_keeps_what_it_knew_of_headings_and_of_the_radio() -> None:
    batches, begin = relayed()
    state = SUREFIX.start(SessionStart())
    for batch in batches[: begin + 6]:
        state, _ = SUREFIX.advance(state, batch, site())
    assert isinstance(state, SurefixState) and state.track is not None and state.rivalry is not None
    above = on_next_floor(state, 2.0)
    assert above.track is not None and above.rivalry is not None
    for before, after in ((state.track, above.track), (state.rivalry.rival, above.rivalry.rival)):
        assert before.headed and not after.headed
        assert after.unseen_m2 == before.unseen_m2 + 4.0 and after.bias_m2 == after.lasting_m2


def test_while_the_floor_is_uncertain_the_level_that_is_told_is_beyond_any_alert_limit() -> None:
    limit_m = 1000.0
    scan = next(scan for batch in HOME.batches for scan in batch.wifi)
    upstairs = next(scan for batch in walked(9, level=1).batches for scan in batch.wifi)
    bssid = np.union1d(scan.bssid, upstairs.bssid)
    torn = WifiScan(scan.time_s, bssid, np.full(len(bssid), -60.0), np.full(len(bssid), scan.time_s))
    state = SUREFIX.start(SessionStart(alert_limit_m=limit_m))
    state, fix = SUREFIX.advance(state, Batch(0, scan.time_s, wifi=(torn,)), site())
    assert isinstance(state, SurefixState) and state.floor is not None and state.floor.certainty < 0.9
    assert fix.integrity.protection_level_m == 3.0 * limit_m and not fix.integrity.usable


def test_a_right_start_is_kept() -> None:
    here = HOME.truth(HOME.batches[0].end_s or 0.0)
    fixes = run(SUREFIX, list(HOME.batches), start=SessionStart(start=Position(float(here[0]), float(here[1]), "F1")))
    assert Flag.FAULT not in flags(fixes)
    assert float(np.mean(errors_m(HOME, fixes))) < 3.0


@pytest.mark.parametrize("seed", [6, 8, 11])
def test_where_nobody_surveyed_levels_stay_wide_and_hold_for_as_long_as_scans_are_unlike_the_survey(seed: int) -> None:
    walk, surveyed_from_m = walked(seed), 40.0
    fixes = [fix for fix in run(SUREFIX, walk.batches, site(surveyed_from_m)) if fix.position is not None]
    level_m = np.array([fix.integrity.protection_level_m for fix in fixes])
    east_m = np.array([walk.truth(fix.time_s or 0.0)[0] for fix in fixes])
    assert (errors_m(walk, fixes) <= level_m).all()
    outside, well_inside = east_m < surveyed_from_m - 8.0, east_m > surveyed_from_m + 8.0
    assert outside.sum() > 30
    assert np.median(level_m[outside]) > 40.0
    assert not well_inside.any() or level_m[well_inside].min() < 15.0


@given(strange_m2=st.tuples(st.floats(0.0, 1e4), st.floats(0.0, 1e4)))
def test_radii_and_covariance_grow_with_strangeness_beyond_what_surveyed_places_have(
    strange_m2: tuple[float, float],
) -> None:
    settings, here = SurefixSettings(), Place(np.zeros(2), 4.0 * np.eye(2), 3.0, 6.0)
    less, more = sorted(strange_m2)
    assert settings.accuracy_m(here, less, DEFAULT) <= settings.accuracy_m(here, more, DEFAULT)
    assert settings.level_m(here, less, 0.01, DEFAULT) <= settings.level_m(here, more, 0.01, DEFAULT)
    assert settings.covariance_m2(here, less, DEFAULT)[0, 0] <= settings.covariance_m2(here, more, DEFAULT)[0, 0]
    if more <= settings.strange_usual_m2:
        assert settings.level_m(here, 0.0, 0.01, DEFAULT) == settings.level_m(here, more, 0.01, DEFAULT)


def test_a_smaller_risk_asks_for_a_wider_level() -> None:
    levels = []
    for risk in (0.05, 0.01, 0.001):
        fixes = run(SUREFIX, list(HOME.batches), start=SessionStart(risk=risk))
        levels.append(fixes[-1].integrity.protection_level_m or 0.0)
    assert levels[0] < levels[1] < levels[2]
    assert [SurefixSettings().tail_at(risk) for risk in (0.05, 0.001)] == [0.81, 2.0]


def test_the_walk_is_followed_within_a_few_metres() -> None:
    assert float(np.mean(errors_m(HOME, run(SUREFIX, list(HOME.batches))))) < 3.0


@pytest.mark.parametrize("seed", [1, 3])
def test_a_phone_that_lies_still_for_ten_minutes_takes_no_step_and_drifts_by_less_than_a_metre(seed: int) -> None:
    """In its first minute scans still bear out, or mend, where the first of them began."""
    fixes = [fix for fix in run(SUREFIX, list(lying(600.0, seed).batches)) if fix.position is not None]
    places = np.array([(fix.position.x_m, fix.position.y_m) for fix in fixes if fix.position is not None])
    assert len(fixes) > 590 and fixes[-1].step_count == 0
    assert np.hypot(*(places - places[60])[60:].T).max() < 1.0


def test_a_scan_that_only_repeats_another_is_no_second_witness() -> None:
    """The phone reports one foreign scan again and again, readings as old as they are."""
    batches = list(HOME.batches)
    attacked, begin = relayed()
    middle = next(n for n in range(begin, len(batches)) if batches[n].wifi)
    foreign = attacked[middle].wifi[0]

    def heard(number: int, seen_s: float) -> Batch:
        scans = (
            replace(foreign, time_s=scan.time_s, seen_s=np.full(len(foreign.bssid), seen_s))
            for scan in batches[number].wifi
        )
        return replace(batches[number], wifi=tuple(scans))

    first_s = batches[middle].wifi[0].time_s
    repeated = [*batches[:middle], *(heard(n, first_s - 0.2) for n in range(middle, middle + 6))]
    renewed = [
        *batches[:middle],
        *(heard(n, (batches[n].end_s or 0.0) - 0.5) for n in range(middle, middle + 6)),
    ]
    assert Flag.OUTLIER in flags(run(SUREFIX, repeated)) and Flag.FAULT not in flags(run(SUREFIX, repeated))
    assert Flag.FAULT in flags(run(SUREFIX, renewed))


def _without(scan: WifiScan, bssids: set[int]) -> WifiScan:
    kept = np.array([int(one) not in bssids for one in scan.bssid], dtype=np.bool_)
    return WifiScan(scan.time_s, scan.bssid[kept], scan.rssi_dbm[kept], scan.seen_s[kept])


def _moved_away(scan: WifiScan) -> WifiScan:
    return WifiScan(scan.time_s, scan.bssid + (1 << 40), scan.rssi_dbm, scan.seen_s)


def test_a_gyroscope_that_gains_a_bias_gives_way_to_the_compass() -> None:
    walk = walked(8, length_m=120.0)
    begin_s = walk.batches[len(walk.batches) // 3].end_s or 0.0
    broken = []
    for batch in walk.batches:
        gyroscope = batch.gyroscope
        values = gyroscope.values + np.where(gyroscope.time_s >= begin_s, 0.25, 0.0)[:, np.newaxis] * [0.0, 0.0, 1.0]
        broken.append(replace(batch, gyroscope=replace(gyroscope, values=values), rotation_vector=AxisSamples()))
    fixes = run(SUREFIX, broken)
    placed = [fix for fix in fixes if fix.position is not None]
    judged = list(zip(placed, errors_m(walk, placed), strict=True))
    assert not any(fix.integrity.usable and error_m > 10.0 for fix, error_m in judged)
    sound = run(SUREFIX, [replace(batch, rotation_vector=AxisSamples()) for batch in walk.batches])
    late = [error_m for fix, error_m in judged if (fix.time_s or 0.0) > begin_s + 15.0]
    without_m = errors_m(walk, [fix for fix in sound if (fix.time_s or 0.0) > begin_s + 15.0])
    assert np.median(late) < np.median(without_m) + 1.0
