"""Method A, `integrity_ukf`: an unscented filter over steps and WiFi fixes that watches its own innovations.

"Integrity monitoring ... WiFi/PDR/smartphone-integrated indoor positioning"; docs/methods/integrity_ukf.md says what
differs and why, and what was measured.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion import walking_ukf as ukf
from app.fusion.advancing import Findings, advanced
from app.fusion.batch_events import Event, knows_turns
from app.fusion.fix_assembly import Phases, Walker, fix_at, no_fix
from app.fusion.floor_choice import chosen_floor, floor_before
from app.fusion.heading_search import HeadingSearch, sigma_of, sought, walked
from app.fusion.integrity_measuring import after_step, measure_fix, noise_of, phases_of
from app.fusion.integrity_settings import IntegritySettings
from app.fusion.interface import Method, SessionStart, Site
from app.fusion.scan_matching import match_scan
from app.fusion.state_codec import storable
from app.fusion.walking_track import (
    Track,
    aged,
    ahead_m,
    begun,
    begun_at_prior,
    headed,
    place,
    scale_of,
)
from app.integrity.fault_detection import is_fault, same_place, streak_after
from app.observations import Batch, Fix, InnovationCheck, RadioFix, WifiScan
from app.pdr.tracker import PdrOutput, PdrState, initial_pdr_state
from app.wifi.floor_decision import FloorBelief


@storable
@dataclass(frozen=True, slots=True, eq=False)
class IntegrityState:
    """Of one session. radio_s : newest usable scan; there is no position before the first.

    streak : failed tests of WiFi in a row.  apart_m : (2,) of the newest failed one, from where the steps lead to the
    fix; None after one that passed.  phases : what the newest test found.
    """

    start: SessionStart
    pdr: PdrState
    floor: FloorBelief | None = None
    phases: Phases = field(default_factory=Phases)
    time_s: float | None = None
    track: Track | None = None
    radio_s: float | None = None
    search: HeadingSearch = field(default_factory=HeadingSearch)
    streak: int = 0
    apart_m: FloatArray | None = None
    step_count: int = 0


def start(session: SessionStart) -> IntegrityState:
    """The state of a session that has reported nothing."""
    return IntegrityState(session, initial_pdr_state())


def advance(state: IntegrityState, batch: Batch, site: Site, settings: IntegritySettings) -> tuple[IntegrityState, Fix]:
    """The state after a batch, and the best estimate at its end."""

    def after(state: IntegrityState, event: Event, findings: Findings) -> IntegrityState:
        findings.evidence.extend(event.moved.steps)
        state = _moved(state, event, settings, findings.checks)
        return state if event.scan is None else _scanned(state, event.scan, event.moved, site, settings, findings)

    return advanced(state, batch, after, partial(_fix, settings=settings))


def _moved(
    state: IntegrityState, event: Event, settings: IntegritySettings, checks: list[InnovationCheck]
) -> IntegrityState:
    """Steps and time that passed since the event before."""
    track, search, steps = state.track, state.search, event.moved.steps
    if track is None and state.start.prior_m is not None and event.time_s is not None:
        track = begun_at_prior(state.start.prior_m, settings.error.least_m2, event.time_s, settings.track)
    if track is not None:
        turns = knows_turns(event)
        for step in steps if settings.use_steps else ():
            track = after_step(track, step, turns, settings, checks)
            search = search if track.headed else walked(search, step) if turns else HeadingSearch()
        if event.time_s is not None:
            moved = event.moved if settings.use_steps else replace(event.moved, inertial_until_s=None)
            track = aged(track, event.time_s, moved, settings.track)
    return replace(
        state, pdr=event.pdr, time_s=event.time_s, track=track, search=search, step_count=state.step_count + len(steps)
    )


def _scanned(
    state: IntegrityState,
    scan: WifiScan,
    moved: PdrOutput,
    site: Site,
    settings: IntegritySettings,
    findings: Findings,
) -> IntegrityState:
    if site.radio_map is None or (state.radio_s is not None and not settings.use_scans):
        return state
    match = match_scan(site.radio_map, scan, settings.matcher, settings.least_known)
    if match is None or state.time_s is None:
        return state
    now_s = state.time_s
    hint = state.start.floor_hint
    floor = chosen_floor(state.floor, hint, site.radio_map, site, match)
    if floor.decided != match.floor:
        match = match_scan(site.radio_map, scan, settings.matcher, settings.least_known, floor.floor)
        if match is None:
            return state
    changed = floor.floor != floor_before(state.floor, hint)
    state = replace(state, floor=floor, radio_s=scan.time_s)
    noise, bias_m2 = noise_of(match, settings)
    heard = RadioFix(scan.time_s, floor.floor, match.xy_m, noise, bias_m2, match.signal_distance, fits=True)
    if state.track is None or changed:
        findings.evidence.append(heard)
        track = begun(match.xy_m, noise, bias_m2, now_s, settings.track, state.track)
        return replace(state, track=track, search=HeadingSearch(), streak=0, apart_m=None, phases=Phases())

    track = replace(state.track, bias_variance_m2=bias_m2)
    forward_m = ahead_m(track, moved)
    tested, check = measure_fix(track, scan.time_s, match.xy_m, noise, bias_m2, forward_m, settings)
    findings.checks.append(check)
    findings.evidence.append(replace(heard, fits=not tested.if2))
    streak = streak_after(state.streak, tested.if2)
    fault = is_fault(streak, settings.monitor)
    apart_m = check.innovation.copy() if tested.if2 else None
    phases = phases_of(tested, check, fault)
    fix_m2 = float(np.trace(noise)) / 2.0 + bias_m2
    if fault and same_place(apart_m, state.apart_m, fix_m2, settings.agree_sigmas):
        track = begun(match.xy_m, noise, bias_m2, now_s, settings.track, track)
        return replace(state, track=track, search=HeadingSearch(), streak=0, apart_m=None, phases=phases)
    track = replace(track, mean=tested.mean, covariance=tested.covariance)
    track, search = (track, state.search) if track.headed else _sought(track, state.search)
    return replace(state, track=track, search=search, streak=streak, apart_m=apart_m, phases=phases)


def _sought(track: Track, search: HeadingSearch) -> tuple[Track, HeadingSearch]:
    """The track with a heading where fixes and steps have given it away, and the search from there on."""
    search, heading = sought(search, track.mean[:2], sigma_of(track.covariance))
    return (track, search) if heading is None else (headed(track, *heading, by_phone=False), HeadingSearch())


def _fix(
    state: IntegrityState, moved: PdrOutput, checks: tuple[InnovationCheck, ...], settings: IntegritySettings
) -> Fix:
    track = state.track
    if track is None:
        return no_fix(state.start, state.time_s, Walker.of(moved, state.step_count))
    heading_rad = float(track.mean[ukf.HEADING]) if track.headed else None
    stride_m = scale_of(track) * track.stride_m
    walker = Walker.of(moved, state.step_count, heading_rad, stride_m, track.stride_s)
    return fix_at(state, *place(track, moved), walker, settings, checks)


def integrity_ukf(method: str = "integrity_ukf", settings: IntegritySettings | None = None) -> Method:
    """The method with these settings."""
    return Method(method, start, partial(advance, settings=settings or IntegritySettings()))


INTEGRITY_UKF = integrity_ukf()
