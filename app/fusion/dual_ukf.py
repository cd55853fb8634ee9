"""Method C, `dual_ukf`: one unscented filter for the phone's attitude, one for the walker's position.

Yu, Na, Liu and Deng, "WiFi/PDR-integrated indoor localization using unconstrained smartphones", EURASIP J. Wireless
Communications and Networking 2019:41; docs/methods/dual_ukf.md says what differs and why, and what was measured.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion import walking_ukf as ukf
from app.fusion.advancing import Findings, advanced
from app.fusion.batch_events import Event, knows_turns
from app.fusion.carried_position import area_match, moved_on
from app.fusion.carried_steps import Carried, CarriedStep, in_frame, reversed_by, taken, turned_round
from app.fusion.dual_settings import DualSettings
from app.fusion.fix_assembly import Phases, Walker, fix_at, no_fix
from app.fusion.floor_choice import chosen_floor, floor_before
from app.fusion.heading_search import HeadingSearch, sigma_of, sought, walked
from app.fusion.integrity_measuring import measure_fix, phases_of
from app.fusion.interface import Method, SessionStart, Site
from app.fusion.state_codec import storable
from app.fusion.walking_track import Track, aged, ahead_m, begun, begun_at_prior, headed, place, scale_of
from app.integrity.fault_detection import is_fault, streak_after
from app.observations import Batch, Carrying, Fix, InnovationCheck, Motion, RadioFix, Step, WifiScan
from app.pdr.carried_phone import advance_carried
from app.pdr.rmpca import LOOKED_AT
from app.pdr.tracker import PdrOutput, PdrState, initial_pdr_state
from app.wifi.floor_decision import FloorBelief
from app.wifi.match import Match

START_BIAS_M2 = 6.0
"""Variance of the lasting error of fixes that a track begun at a `start` expects, before there is a fix."""
SWINGS_FOR_S = 3.0
"""After the last window of movement."""


@storable
@dataclass(frozen=True, slots=True, eq=False)
class DualState:
    """Of one session. radio_s : newest usable scan; there is no position before the first.

    search : where north is, for a phone that does not know, and whether the way was taken for its opposite, for one
    that does.  streak : failed tests of WiFi in a row.  phases : what the newest test found.
    """

    start: SessionStart
    pdr: PdrState
    carried: Carried = field(default_factory=Carried)
    floor: FloorBelief | None = None
    phases: Phases = field(default_factory=Phases)
    time_s: float | None = None
    track: Track | None = None
    radio_s: float | None = None
    search: HeadingSearch = field(default_factory=HeadingSearch)
    streak: int = 0
    step_count: int = 0


def start(session: SessionStart) -> DualState:
    """The state of a session that has reported nothing."""
    return DualState(session, initial_pdr_state())


def advance(state: DualState, batch: Batch, site: Site, settings: DualSettings) -> tuple[DualState, Fix]:
    """The state after a batch, and the best estimate at its end."""

    def after(state: DualState, event: Event, findings: Findings) -> DualState:
        state = _moved(state, event, batch, settings, findings.evidence)
        return state if event.scan is None else _scanned(state, event.scan, event.moved, site, settings, findings)

    return advanced(state, batch, after, partial(_fix, settings=settings))


def _moved(
    state: DualState, event: Event, batch: Batch, settings: DualSettings, evidence: list[Step | RadioFix]
) -> DualState:
    """Steps and time that passed since the event before."""
    track, search, carried, count = state.track, state.search, state.carried, state.step_count
    if track is None and state.start.prior_m is not None and event.time_s is not None:
        track = begun_at_prior(state.start.prior_m, START_BIAS_M2, event.time_s, settings.track)
    until_s = None if event.scan is None else event.scan.time_s
    turns = knows_turns(event)
    for step in event.moved.steps:
        carried, one = taken(carried, step, batch, until_s, settings)
        if one is None:
            continue
        count += 1
        evidence.append(one.told)
        if track is not None and settings.use_steps:
            search = walked(search, one.step) if turns or one.north else HeadingSearch()
            track = moved_on(_faced(track, one, carried, turns), one, settings)
    phone = advance_carried(carried.phone, batch, settings.quaternion, until_s)
    carried = in_frame(replace(carried, phone=phone))
    if track is not None and event.time_s is not None:
        blind = not settings.use_steps or _unheard(carried, event)
        seen = replace(event.moved, inertial_until_s=None) if blind else event.moved
        track = aged(track, event.time_s, seen, settings.track)
    return replace(
        state,
        pdr=event.pdr,
        time_s=event.time_s,
        carried=carried,
        track=track,
        search=search,
        step_count=count,
    )


def _unheard(carried: Carried, event: Event) -> bool:
    """Whether a limb swings and yet no step is told: then there are steps that nobody counts."""
    newest_s = float(carried.phone.recognised.answers[-1, 0])
    if event.time_s is None or event.moved.motion is not Motion.UNKNOWN or event.time_s - newest_s > SWINGS_FOR_S:
        return False
    return carried.phone.recognised.at(event.time_s) in (Carrying.SWINGING, Carrying.POCKET)


def _faced(track: Track, one: CarriedStep, carried: Carried, turns: bool) -> Track:
    """The track with the heading of this step: an input of the position filter, not a part of what it estimates."""
    sigma_rad = math.sqrt(one.heading_variance)
    if one.north and one.end_known:
        return headed(track, one.step.heading_rad, sigma_rad)
    if not one.north and carried.offset_rad is not None and turns:
        return headed(track, one.step.heading_rad + carried.offset_rad, sigma_rad, by_phone=False)
    return replace(track, headed=False)


def _scanned(
    state: DualState,
    scan: WifiScan,
    moved: PdrOutput,
    site: Site,
    settings: DualSettings,
    findings: Findings,
) -> DualState:
    if site.radio_map is None or state.time_s is None or (state.radio_s is not None and not settings.use_scans):
        return state
    match = area_match(site.radio_map, scan, None, None, settings)
    if match is None:
        return state
    now_s = state.time_s
    hint = state.start.floor_hint
    floor = chosen_floor(state.floor, hint, site.radio_map, site, match)
    changed = floor.floor != floor_before(state.floor, hint)
    match = area_match(site.radio_map, scan, floor.floor, None if changed else state.track, settings)
    if match is None:
        return state
    state = replace(state, floor=floor, radio_s=scan.time_s)
    noise, bias_m2 = _noise_of(match, settings)
    heard = RadioFix(scan.time_s, floor.floor, match.xy_m, noise, bias_m2, match.signal_distance, fits=True)
    if state.track is None or changed:
        findings.evidence.append(heard)
        track = begun(match.xy_m, noise, bias_m2, now_s, settings.track, state.track)
        return replace(state, track=track, search=HeadingSearch(), streak=0, phases=Phases())

    track = replace(state.track, bias_variance_m2=bias_m2)
    forward_m = ahead_m(track, moved)
    tested, check = measure_fix(track, scan.time_s, match.xy_m, noise, bias_m2, forward_m, settings)
    findings.checks.append(check)
    findings.evidence.append(replace(heard, fits=not tested.if2))
    streak = streak_after(state.streak, tested.if2)
    fault = is_fault(streak, settings.monitor)
    phases = phases_of(tested, check, fault)
    if fault:
        track = begun(match.xy_m, noise, bias_m2, now_s, settings.track, track)
        return replace(state, track=track, search=HeadingSearch(), streak=0, phases=phases)
    track = replace(track, mean=tested.mean, covariance=tested.covariance)
    state = replace(state, track=track, streak=streak, phases=phases)
    return _sought(state, match.xy_m, sigma_of(match.covariance_m2))


def _sought(state: DualState, fix_m: FloatArray, sigma_m: float) -> DualState:
    """What fixes and steps give away of the way: north, or that it was taken for its opposite."""
    track, carried = state.track, state.carried
    search, heading = sought(state.search, fix_m, sigma_m)
    state = replace(state, search=search)
    if heading is None or track is None:
        return state
    north = carried.phone.motion.is_absolute
    if not north and carried.offset_rad is None:
        carried = replace(carried, offset_rad=heading[0] - search.heading_rad)
        return replace(state, carried=carried, track=headed(track, *heading, by_phone=False), search=HeadingSearch())
    if north and _carrying(state) not in LOOKED_AT and reversed_by(search, heading[0], carried.end_known):
        carried = turned_round(carried)
    return replace(state, carried=replace(carried, end_known=True), search=HeadingSearch())


def _noise_of(match: Match, settings: DualSettings) -> tuple[FloatArray, float]:
    """Independent noise (2, 2) of a fix, and the variance of its lasting error in each direction."""
    if settings.empirical is None:
        misfit_m2 = settings.misfit_m2 * match.signal_distance**2
        covariance_m2 = settings.fix_scale * match.covariance_m2 + misfit_m2 * np.eye(2)
    else:
        covariance_m2 = settings.empirical.fix_m**2 * np.eye(2)
    return (1.0 - settings.lasting) * covariance_m2, settings.lasting * float(np.trace(covariance_m2)) / 2.0


def _carrying(state: DualState) -> Carrying:
    return Carrying.UNKNOWN if state.time_s is None else state.carried.phone.recognised.at(state.time_s)


def _fix(state: DualState, moved: PdrOutput, checks: tuple[InnovationCheck, ...], settings: DualSettings) -> Fix:
    track, carrying = state.track, _carrying(state)
    if track is None:
        return no_fix(state.start, state.time_s, Walker.of(moved, state.step_count, carrying=carrying))
    heading_rad = float(track.mean[ukf.HEADING]) if track.headed else None
    stride_m = scale_of(track) * track.stride_m
    walker = Walker.of(moved, state.step_count, heading_rad, stride_m, track.stride_s, carrying)
    return fix_at(state, *place(track, moved), walker, settings, checks)


def dual_ukf(method: str = "dual_ukf", settings: DualSettings | None = None) -> Method:
    """The method with these settings."""
    return Method(method, start, partial(advance, settings=settings or DualSettings()))


DUAL_UKF = dual_ukf()
