"""Method B, `two_stage_ekf`: an attitude filter turns the steps, a position filter joins them with WiFi.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198; docs/methods/two_stage_ekf.md says what differs and
why, and what was measured.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion import position_ekf as ekf
from app.fusion.advancing import Findings, advanced
from app.fusion.batch_events import Event, knows_turns
from app.fusion.fix_assembly import Phases, Walker, fix_at, no_fix
from app.fusion.fix_trial import tried
from app.fusion.floor_choice import chosen_floor, floor_before
from app.fusion.heading_search import HeadingSearch, walked
from app.fusion.interface import START_SIGMA_M, Method, SessionStart, Site
from app.fusion.position_ekf import StepTrack
from app.fusion.scan_matching import HEAVY_TAILS, said
from app.fusion.state_codec import storable
from app.fusion.two_stage_measuring import after_direction, after_step, north_sought
from app.fusion.two_stage_settings import TwoStageSettings
from app.fusion.wifi_direction import FIXES
from app.observations import Batch, Fix, InnovationCheck, WifiScan
from app.pdr.attitude_ekf import EulerState, advance_attitude
from app.pdr.tracker import PdrOutput, PdrState, initial_pdr_state
from app.pdr.turn_detection import last_turn_s, straight_since
from app.wifi.floor_decision import FloorBelief
from app.wifi.match import Match
from app.wifi.moving_partition import Partition
from app.wifi.partition_search import SearchState, place_scan
from app.wifi.radio_map import RadioMap
from app.wifi.readings import fresh_readings
from app.wifi.strongest_wknn import strongest_wknn


@storable
@dataclass(frozen=True, slots=True, eq=False)
class TwoStageState:
    """Of one session. radio_s : newest usable scan; there is no position before the first.

    fixes : (n, 3) times and places of the newest that passed, oldest first.  turned_s : newest step that was a turn.
    north : where north is, for a phone that does not know.  streak : failed tests of WiFi in a row.
    phases : what the newest test found.
    """

    start: SessionStart
    pdr: PdrState
    attitude: EulerState = field(default_factory=EulerState)
    search: SearchState = field(default_factory=SearchState)
    floor: FloorBelief | None = None
    phases: Phases = field(default_factory=Phases)
    time_s: float | None = None
    track: StepTrack | None = None
    radio_s: float | None = None
    fixes: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    turned_s: float = -math.inf
    north: HeadingSearch = field(default_factory=HeadingSearch)
    streak: int = 0
    step_count: int = 0


for _kind in (EulerState, SearchState, Partition):
    storable(_kind)


def start(session: SessionStart) -> TwoStageState:
    """The state of a session that has reported nothing."""
    return TwoStageState(session, initial_pdr_state())


def advance(state: TwoStageState, batch: Batch, site: Site, settings: TwoStageSettings) -> tuple[TwoStageState, Fix]:
    """The state after a batch, and the best estimate at its end."""

    def after(state: TwoStageState, event: Event, findings: Findings) -> TwoStageState:
        findings.evidence.extend(event.moved.steps)
        until_s = None if event.scan is None else event.scan.time_s
        state = replace(state, attitude=advance_attitude(state.attitude, batch, settings.attitude, until_s))
        state = _moved(state, event, settings, findings.checks)
        return state if event.scan is None else _scanned(state, event.scan, event.moved, site, settings, findings)

    return advanced(state, batch, after, partial(_fix, settings=settings))


def _moved(
    state: TwoStageState, event: Event, settings: TwoStageSettings, checks: list[InnovationCheck]
) -> TwoStageState:
    """Steps and time that passed since the event before."""
    track, north, moved = state.track, state.north, event.moved
    if track is None and state.start.prior_m is not None and event.time_s is not None:
        track = ekf.begun(state.start.prior_m, START_SIGMA_M**2, event.time_s, settings.position)
    if track is not None:
        turns = knows_turns(event)
        for step in moved.steps if settings.use_steps else ():
            track = after_step(track, step, state.attitude, turns, settings, checks)
            north = north if track.headed else walked(north, step) if turns else HeadingSearch()
        if event.time_s is not None:
            blind = moved if settings.use_steps else replace(moved, inertial_until_s=None)
            track = ekf.aged(track, event.time_s, blind)
    return replace(
        state,
        pdr=event.pdr,
        time_s=event.time_s,
        track=track,
        north=north,
        turned_s=last_turn_s(state.turned_s, moved.steps, settings.turn_rad),
        step_count=state.step_count + len(moved.steps),
    )


def _scanned(
    state: TwoStageState,
    scan: WifiScan,
    moved: PdrOutput,
    site: Site,
    settings: TwoStageSettings,
    findings: Findings,
) -> TwoStageState:
    if site.radio_map is None or state.time_s is None or (state.radio_s is not None and not settings.use_scans):
        return state
    before = floor_before(state.floor, state.start.floor_hint)
    state, match = _matched(state, fresh_readings(scan), before, site.radio_map, site, settings)
    floor, track = state.floor, state.track
    if match is None or floor is None:
        return state
    state = replace(state, radio_s=scan.time_s)
    if track is None or floor.floor != before:
        findings.evidence.append(said(scan, floor.floor, match, HEAVY_TAILS * settings.error_m2, fits=True))
        return _begun(state, scan, match, Phases(), settings)
    xy_m, jacobian = ekf.place(track, moved)
    innovation = match.xy_m - xy_m
    spread = jacobian @ track.covariance @ jacobian.T + settings.error_m2 * np.eye(2)
    seen = tried(scan.time_s, innovation, spread, state.streak, settings.trial)
    findings.checks.append(seen.check)
    findings.evidence.append(said(scan, floor.floor, match, HEAVY_TAILS * settings.error_m2, seen.passed))
    if seen.fault:
        return _begun(state, scan, match, seen.phases, settings)
    state = replace(state, streak=seen.streak, phases=seen.phases)
    if not seen.passed:
        return state
    track = ekf.measured(track, innovation, jacobian, settings.position.of_fix_m2(match) * np.eye(2))
    fixes = np.concatenate([state.fixes[1 - FIXES :], [[state.time_s, *match.xy_m]]])
    if not track.headed:
        track, north = north_sought(track, state.north)
        return replace(state, track=track, fixes=fixes, north=north)
    if settings.use_direction and straight_since(state.turned_s, float(fixes[0, 0])):
        track = after_direction(track, fixes[:, 1:], scan.time_s, settings, findings.checks)
    return replace(state, track=track, fixes=fixes)


def _matched(
    state: TwoStageState,
    scan: WifiScan,
    before: str | None,
    radio_map: RadioMap,
    site: Site,
    settings: TwoStageSettings,
) -> tuple[TwoStageState, Match | None]:
    """The scan's place on the floor that holds, and what it says of the floor. before : floor until now."""
    where = None if state.floor is None or before not in radio_map.floors else radio_map.floors.index(before)
    search, match, everywhere = place_scan(state.search, radio_map, scan, where, settings.search)
    if match is None or match.known < settings.least_known:
        return state, None
    if not everywhere:
        return replace(state, search=search), match
    floor = chosen_floor(state.floor, before, radio_map, site, match)
    state = replace(state, search=search, floor=floor)
    if floor.decided == match.floor:
        return state, match
    # stays lost, so that the next scan is asked for its floor too
    state = replace(state, search=replace(search, partition=None))
    strongest = settings.search.strongest
    return state, strongest_wknn(radio_map, scan.bssid, scan.rssi_dbm, strongest, floor.decided)


def _begun(
    state: TwoStageState, scan: WifiScan, match: Match, phases: Phases, settings: TwoStageSettings
) -> TwoStageState:
    """The state with a track that begins at a fix."""
    time_s = scan.time_s if state.time_s is None else state.time_s
    track = ekf.begun(match.xy_m, settings.error_m2, time_s, settings.position)
    fixes = np.array([[time_s, *match.xy_m]])
    return replace(state, track=track, fixes=fixes, north=HeadingSearch(), streak=0, phases=phases)


def _fix(
    state: TwoStageState, moved: PdrOutput, checks: tuple[InnovationCheck, ...], settings: TwoStageSettings
) -> Fix:
    track = state.track
    if track is None:
        return no_fix(state.start, state.time_s, Walker.of(moved, state.step_count))
    heading_rad = float(track.mean[ekf.HEADING]) if track.headed else None
    stride_m = float(track.mean[ekf.LENGTH])
    walker = Walker.of(moved, state.step_count, heading_rad, stride_m, track.stride_s)
    xy_m, jacobian = ekf.place(track, moved)
    spread = jacobian @ track.covariance @ jacobian.T + settings.lasting_m2 * np.eye(2)
    return fix_at(state, xy_m, spread, walker, settings, checks)


def two_stage_ekf(method: str = "two_stage_ekf", settings: TwoStageSettings | None = None) -> Method:
    """The method with these settings."""
    return Method(method, start, partial(advance, settings=settings or TwoStageSettings()))


TWO_STAGE_EKF = two_stage_ekf()
