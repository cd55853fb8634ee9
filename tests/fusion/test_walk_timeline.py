from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.fusion.walk_timeline import BLIND_AFTER_S, MOST_BLIND, Moment, Timeline, timeline
from app.observations import Motion, RadioFix, Step


def step(time_s: float, **more: float) -> Step:
    return replace(Step(time_s, 0.5, 0.7, 1.0, 0.2, 0.1, math.nan), **more)


def scan(time_s: float, floor: str = "F1") -> RadioFix:
    return RadioFix(time_s, floor, np.zeros(2), np.eye(2), 1.0, 0.1, fits=True)


def line_of(evidence: list[Step | RadioFix], moments: list[Moment] | None = None) -> Timeline:
    line = timeline(evidence, moments or [])
    assert line is not None
    return line


def test_a_step_told_late_stands_before_the_scan_that_came_first() -> None:
    line = line_of([scan(1.2), step(1.0), step(1.5)])
    link, share = line.at(np.array([0.4, 0.75, 1.0, 1.2, 1.5, 9.0]))
    assert link.tolist() == [0, 0, 1, 1, 1, 1]
    assert share == pytest.approx([0.0, 0.5, 0.0, 0.4, 1.0, 1.0])


def test_a_step_lasts_no_longer_than_since_the_one_before() -> None:
    line = line_of([scan(0.0), step(1.0), step(1.2, duration_s=5.0)])
    assert [(link.start_s, link.end_s) for link in line.links] == [(0.5, 1.0), (1.0, 1.2)]


@given(st.lists(st.floats(0.0, 30.0), max_size=20), st.lists(st.floats(0.0, 30.0), min_size=1, max_size=8))
def test_links_follow_each_other_and_hold_every_time(step_times: list[float], scan_times: list[float]) -> None:
    floors = ["F1" if time_s < 15.0 else "F2" for time_s in scan_times]
    evidence: list[Step | RadioFix] = [*map(step, step_times), *map(scan, scan_times, floors)]
    line = line_of(evidence, [Moment(float(k), Motion.UNKNOWN) for k in range(0, 31, 3)])
    ends = [link.end_s for link in line.links]
    assert ends == sorted(ends)
    assert all(link.start_s <= link.end_s for link in line.links)
    link, share = line.at(np.array([*step_times, *scan_times, -1.0, 99.0]))
    assert ((share >= 0.0) & (share <= 1.0)).all()
    assert ((link >= 0) & (link < len(line.links))).all()


def test_turns_without_gyroscope_and_north_are_not_known() -> None:
    line = line_of([scan(0.0), step(1.0, heading_sigma_rad=math.pi, heading_change_rad=0.0), step(1.5)])
    assert [link.turns for link in line.links] == [False, True]
    assert [math.isnan(link.phone_rad) for link in line.links] == [True, False]


def test_a_gyroscope_that_drifts_from_the_compass_is_not_believed_from_the_beginning() -> None:
    walk = [step(0.5 * k, heading_change_rad=0.2, magnetic_heading_rad=0.5) for k in range(1, 40)]
    assert not any(link.turns or link.north for link in line_of([scan(0.0), *walk]).links)


def test_the_step_under_way_is_begun() -> None:
    links = line_of([scan(0.0), step(1.0)], [Moment(1.25, Motion.WALKING)]).links
    assert [link.length_m for link in links] == pytest.approx([0.7, 0.35])
    stopped = line_of([scan(0.0), step(1.0)], [Moment(3.0, Motion.WALKING)]).links
    assert len(stopped) == 1


@pytest.mark.parametrize(("motion", "blind"), [(Motion.STILL, 0.0), (Motion.UNKNOWN, 20.0)])
def test_time_without_steps_is_blind_unless_the_phone_was_still(motion: Motion, blind: float) -> None:
    moments = [Moment(1.0, Motion.WALKING), *(Moment(1.0 + k, motion) for k in range(1, 21))]
    line = line_of([scan(0.0), step(1.0)], moments)
    assert sum(link.blind_s for link in line.links) == pytest.approx(blind)


def test_a_short_time_without_steps_is_not() -> None:
    moments = [Moment(1.0, Motion.WALKING), Moment(1.0 + 0.9 * BLIND_AFTER_S, Motion.UNKNOWN)]
    assert all(link.blind_s == 0.0 for link in line_of([scan(0.0), step(1.0)], moments).links)


def test_a_floor_begins_with_the_scan_that_says_so() -> None:
    line = line_of([scan(0.0), step(1.0), scan(1.2, "F2"), step(2.0), scan(2.5, "F2")])
    assert [link.new_floor for link in line.links] == [False, True, False]
    assert line.floors(np.array([-1.0, 1.1, 1.2, 9.0])) == ["F1", "F1", "F2", "F2"]
    link, share = line.at(np.array([1.2]))
    assert (int(link[0]), float(share[0])) == (2, 0.0)


def test_without_a_scan_there_is_no_line() -> None:
    assert timeline([step(1.0)], []) is None


def test_days_without_steps_are_blind_in_a_bounded_number_of_pieces() -> None:
    line = line_of([scan(0.0)], [Moment(3600.0 * k, Motion.UNKNOWN) for k in range(101)])
    assert len(line.links) <= MOST_BLIND + 100
    assert sum(link.blind_s for link in line.links) == pytest.approx(360_000.0)
