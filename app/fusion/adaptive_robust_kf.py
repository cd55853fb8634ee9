"""Method D, `adaptive_robust_kf`: an error-state filter, its noise by context, its trust in each fix by an F test.

"An improved WiFi/PDR integrated system using an adaptive and robust filter for indoor localization";
docs/methods/adaptive_robust_kf.md says what differs and why, and what was measured.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from app.estimation.arrays import FloatArray
from app.floorplan.openness import Surroundings, surroundings_of
from app.fusion.adaptive_robust_settings import AdaptiveRobustSettings
from app.fusion.advancing import Findings, advanced
from app.fusion.batch_events import Event, knows_turns
from app.fusion.error_track import ErrorTrack, aged, begun, headed, place, stepped
from app.fusion.fix_assembly import Phases, Walker, fix_at, no_fix
from app.fusion.floor_choice import chosen_floor, floor_before
from app.fusion.heading_search import HeadingSearch, sigma_of, sought, walked
from app.fusion.interface import START_SIGMA_M, Method, SessionStart, Site
from app.fusion.robust_measuring import process_noise, robust_update
from app.fusion.scan_matching import match_scan, said
from app.fusion.state_codec import storable
from app.integrity.fault_detection import same_place, streak_after
from app.observations import Batch, Fix, InnovationCheck, WifiScan
from app.pdr.step_length import linear_length_m, swing_of_mps2
from app.pdr.tracker import PdrOutput, PdrState, initial_pdr_state
from app.pdr.walking_context import WalkingContext, context_after
from app.wifi.floor_decision import FloorBelief
from app.wifi.readings import fresh_readings


@storable
@dataclass(frozen=True, slots=True, eq=False)
class AdaptiveRobustState:
    """Of one session. radio_s : newest usable scan; there is no position before the first.

    streak : outliers of WiFi in a row.  apart_m : (2,) of the newest one, from where the steps lead to the fix; None
    after one that passed.  phases : what the newest test found.
    """

    start: SessionStart
    pdr: PdrState
    context: WalkingContext = field(default_factory=WalkingContext)
    surroundings: Surroundings = Surroundings.OPEN
    floor: FloorBelief | None = None
    phases: Phases = field(default_factory=Phases)
    time_s: float | None = None
    track: ErrorTrack | None = None
    radio_s: float | None = None
    search: HeadingSearch = field(default_factory=HeadingSearch)
    streak: int = 0
    apart_m: FloatArray | None = None
    step_count: int = 0


for _kind in (WalkingContext, Surroundings):
    storable(_kind)


def start(session: SessionStart) -> AdaptiveRobustState:
    """The state of a session that has reported nothing."""
    return AdaptiveRobustState(session, initial_pdr_state())


def advance(
    state: AdaptiveRobustState, batch: Batch, site: Site, settings: AdaptiveRobustSettings
) -> tuple[AdaptiveRobustState, Fix]:
    """The state after a batch, and the best estimate at its end."""

    def after(state: AdaptiveRobustState, event: Event, findings: Findings) -> AdaptiveRobustState:
        findings.evidence.extend(event.moved.steps)
        state = _moved(state, event, settings)
        return state if event.scan is None else _scanned(state, event.scan, event.moved, site, settings, findings)

    return advanced(state, batch, after, partial(_fix, settings=settings))


def _moved(state: AdaptiveRobustState, event: Event, settings: AdaptiveRobustSettings) -> AdaptiveRobustState:
    """Steps and time that passed since the event before."""
    track, search, context, steps = state.track, state.search, state.context, event.moved.steps
    if track is None and state.start.prior_m is not None and event.time_s is not None:
        track = begun(state.start.prior_m, START_SIGMA_M**2 * np.eye(2), event.time_s, settings)
    turns = knows_turns(event)
    for step in steps:
        context = context_after(context, step)
        if track is not None:
            noise = process_noise(context, state.surroundings, settings)
            track = stepped(
                track, step, linear_length_m(step.duration_s, swing_of_mps2(step.length_m)), turns, noise, settings
            )
            search = search if track.headed else walked(search, step) if turns else HeadingSearch()
    if track is not None and event.time_s is not None:
        track = aged(track, event.time_s, event.moved)
    return replace(
        state,
        pdr=event.pdr,
        time_s=event.time_s,
        track=track,
        search=search,
        context=context,
        step_count=state.step_count + len(steps),
    )


def _scanned(
    state: AdaptiveRobustState,
    scan: WifiScan,
    moved: PdrOutput,
    site: Site,
    settings: AdaptiveRobustSettings,
    findings: Findings,
) -> AdaptiveRobustState:
    match = match_scan(site.radio_map, scan, settings.matcher, settings.least_known)
    if match is None or site.radio_map is None or state.time_s is None:
        return state
    hint = state.start.floor_hint
    floor = chosen_floor(state.floor, hint, site.radio_map, site, match)
    if floor.decided != match.floor:
        match = match_scan(site.radio_map, scan, settings.matcher, settings.least_known, floor.floor)
        if match is None:
            return state
    changed = floor.floor != floor_before(state.floor, hint)
    at_m = match.xy_m if state.track is None or changed else place(state.track, moved)[0]
    surroundings = surroundings_of(fresh_readings(scan).rssi_dbm, at_m, site.space(floor.floor))
    state = replace(state, floor=floor, radio_s=scan.time_s, surroundings=surroundings)
    variance_m2, track = settings.error.variance_m2(match), state.track
    if track is None or changed:
        findings.evidence.append(said(scan, floor.floor, match, variance_m2, fits=True))
        return _begun(state, match.xy_m, variance_m2, settings)

    updated = robust_update(track, scan.time_s, match.xy_m, variance_m2, moved, settings)
    findings.checks.append(updated.check)
    findings.evidence.append(said(scan, floor.floor, match, variance_m2, not updated.phases.if2))
    streak = streak_after(state.streak, updated.phases.if2)
    fault = streak >= settings.fault_after
    apart_m = updated.check.innovation.copy() if updated.phases.if2 else None
    phases = replace(updated.phases, if3=int(fault))
    if fault and same_place(apart_m, state.apart_m, variance_m2, settings.agree_sigmas):
        return replace(_begun(state, match.xy_m, variance_m2, settings), phases=phases)
    track, search = (updated.track, state.search) if track.headed else _sought(updated.track, state.search)
    return replace(state, track=track, search=search, streak=streak, apart_m=apart_m, phases=phases)


def _begun(
    state: AdaptiveRobustState, xy_m: FloatArray, variance_m2: float, settings: AdaptiveRobustSettings
) -> AdaptiveRobustState:
    """The state with a track that begins at a fix."""
    if state.time_s is None:
        raise RuntimeError("a scan has a time")
    track = begun(xy_m, variance_m2 * np.eye(2), state.time_s, settings, state.track)
    return replace(state, track=track, search=HeadingSearch(), streak=0, apart_m=None, phases=Phases())


def _sought(track: ErrorTrack, search: HeadingSearch) -> tuple[ErrorTrack, HeadingSearch]:
    """The track with a heading where fixes and steps have given it away."""
    search, heading = sought(search, track.xy_m, sigma_of(track.covariance))
    if heading is None:
        return track, search
    return headed(track, heading[0] - search.heading_rad, heading[1]), HeadingSearch()


def _fix(
    state: AdaptiveRobustState, moved: PdrOutput, checks: tuple[InnovationCheck, ...], settings: AdaptiveRobustSettings
) -> Fix:
    track = state.track
    if track is None:
        return no_fix(state.start, state.time_s, Walker.of(moved, state.step_count))
    heading_rad = track.direction_rad if track.headed else None
    walker = Walker.of(moved, state.step_count, heading_rad, track.stride_m, track.stride_s)
    xy_m, jacobian = place(track, moved)
    covariance_m2 = settings.inflation * (jacobian @ track.covariance @ jacobian.T)
    return fix_at(state, xy_m, covariance_m2, walker, settings, checks)


def adaptive_robust_kf(method: str = "adaptive_robust_kf", settings: AdaptiveRobustSettings | None = None) -> Method:
    """The method with these settings."""
    return Method(method, start, partial(advance, settings=settings or AdaptiveRobustSettings()))


ADAPTIVE_ROBUST_KF = adaptive_robust_kf()
