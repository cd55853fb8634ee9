"""`surefix`, the default: what measured best of the published methods, and integrity that none of them has.

Steps move an unscented filter that also learns the walker's step length, how the phone is held, and the slowly varying
error of the WiFi fixes around (app/fusion/walking_track.py). Fixes are soft matches over a smoothed map, each with the
variance that this building's survey taught (app/wifi/fix_calibration.py). A fix that steps cannot have led to begins a
rival track (app/fusion/hypotheses.py). docs/methods/surefix.md says what each part measured.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion import walking_ukf as ukf
from app.fusion.batch_events import Event, events, knows_turns
from app.fusion.fix_assembly import Estimate, Phases, Walker, assembled_fix, no_fix
from app.fusion.floor_choice import chosen_floor
from app.fusion.heading_search import HeadingSearch, sought, walked
from app.fusion.hypotheses import Rivalry, exchanged, first_is_back, judged, rival_wins
from app.fusion.integrity_measuring import after_step
from app.fusion.interface import START_SIGMA_M, Method, SessionStart, Site
from app.fusion.scan_matching import Matcher, match_scan
from app.fusion.state_codec import storable
from app.fusion.surefix_measuring import TestedFix, phases_of, tested
from app.fusion.surefix_settings import SurefixSettings
from app.fusion.walking_track import Track, aged, begun, place, scale_of, speed_mps, unbiased
from app.integrity.protection_level import protection_level_m
from app.observations import Batch, Fix, InnovationCheck, Position, RadioFix, Step, WifiScan
from app.pdr.tracker import PdrOutput, PdrState, initial_pdr_state
from app.pdr.turn_doubt import TurnRecord, noted, turns_doubted
from app.wifi.fix_calibration import calibration_of
from app.wifi.floor_decision import FloorBelief
from app.wifi.match import Match

storable(TurnRecord)


@storable
@dataclass(frozen=True, slots=True, eq=False)
class SurefixState:
    """Of one session. radio_s : newest usable scan; there is no position before the first.

    track : the account of steps and scans that is answered from.  rivalry : another one, None while nothing
    contradicts.  prior_only : the track began at the phone's `start`, and no scan has borne it out yet.
    phases : what the newest scan's test found.
    """

    start: SessionStart
    pdr: PdrState
    floor: FloorBelief | None = None
    phases: Phases = field(default_factory=Phases)
    time_s: float | None = None
    track: Track | None = None
    rivalry: Rivalry | None = None
    prior_only: bool = False
    radio_s: float | None = None
    search: HeadingSearch = field(default_factory=HeadingSearch)
    turns: TurnRecord = field(default_factory=TurnRecord)
    step_count: int = 0


def start(session: SessionStart) -> SurefixState:
    """The state of a session that has reported nothing."""
    return SurefixState(session, initial_pdr_state())


def advance(state: SurefixState, batch: Batch, site: Site, settings: SurefixSettings) -> tuple[SurefixState, Fix]:
    """The state after a batch, and the best estimate at its end."""
    checks, evidence = list[InnovationCheck](), list[Step | RadioFix]()
    moved: PdrOutput | None = None
    for event in events(state.pdr, state.time_s, batch):
        moved = event.moved
        evidence += moved.steps
        state = _moved(state, event, settings, checks)
        if event.scan is not None:
            state = _scanned(state, _trusted(event.scan, site), moved, site, settings, checks, evidence)
    if moved is None:
        raise RuntimeError("a batch has an end")
    return state, replace(_fix(state, moved, settings, tuple(checks)), evidence=tuple(evidence))


def _trusted(scan: WifiScan, site: Site) -> WifiScan:
    """The scan without access points on the venue's watch list."""
    if not site.watched:
        return scan
    kept = np.array([bssid not in site.watched for bssid in scan.bssid.tolist()], dtype=np.bool_)
    return replace(scan, bssid=scan.bssid[kept], rssi_dbm=scan.rssi_dbm[kept], seen_s=scan.seen_s[kept])


def _moved(state: SurefixState, event: Event, settings: SurefixSettings, checks: list[InnovationCheck]) -> SurefixState:
    """Steps and time that passed since the event before, for both accounts."""
    track, rivalry, search, record = state.track, state.rivalry, state.search, state.turns
    steps = list[Step]()
    for step in event.moved.steps:
        record = noted(record, step)
        steps.append(replace(step, heading_sigma_rad=math.pi) if turns_doubted(record) else step)
    turns = knows_turns(event) and not turns_doubted(record)
    if track is None and state.start.start is not None and event.time_s is not None:
        prior, noise = state.start.start, START_SIGMA_M**2 * np.eye(2)
        track = begun(np.array([prior.x_m, prior.y_m]), noise, START_SIGMA_M**2, event.time_s, settings.track)
        track, state = unbiased(track, noise), replace(state, prior_only=True)
    if track is not None:
        for step in steps:
            track = after_step(track, step, turns, settings.steps, checks)
            search = search if track.headed else walked(search, step) if turns else HeadingSearch()
        if event.time_s is not None:
            track = aged(track, event.time_s, event.moved, settings.track)
    if rivalry is not None:
        rival, unread = rivalry.rival, list[InnovationCheck]()
        for step in steps:
            rival = after_step(rival, step, turns, settings.steps, unread)
        if event.time_s is not None:
            rival = aged(rival, event.time_s, event.moved, settings.track)
        way_m = scale_of(rival) * sum(step.length_m for step in steps)
        rivalry = replace(rivalry, rival=rival, walked_m=rivalry.walked_m + way_m)
    count = state.step_count + len(steps)
    return replace(
        state,
        pdr=event.pdr,
        time_s=event.time_s,
        track=track,
        rivalry=rivalry,
        search=search,
        turns=record,
        step_count=count,
    )


def _scanned(
    state: SurefixState,
    scan: WifiScan,
    moved: PdrOutput,
    site: Site,
    settings: SurefixSettings,
    checks: list[InnovationCheck],
    evidence: list[Step | RadioFix],
) -> SurefixState:
    now_s = state.time_s
    if site.radio_map is None or now_s is None:
        return state
    match = match_scan(site.radio_map, scan, Matcher.SOFT, settings.least_known)
    if match is None or (state.track is None and match.signal_distance >= settings.unlike):
        return state
    told = state.start.floor if state.start.start is None else state.start.start.floor
    floor = chosen_floor(state.floor, told, site.radio_map, site, match)
    if floor.decided != match.floor:
        match = match_scan(site.radio_map, scan, Matcher.SOFT, settings.least_known, floor.floor)
        if match is None:
            return state
    changed = floor.floor != (told if state.floor is None else state.floor.floor)
    variance_m2 = calibration_of(site.radio_map).variance_m2(match, settings.distance_weight)
    noise, bias_m2 = (1.0 - settings.lasting) * variance_m2 * np.eye(2), settings.lasting * variance_m2
    state = replace(state, floor=floor, radio_s=scan.time_s)
    said = RadioFix(scan.time_s, floor.floor, match.xy_m, noise, bias_m2, match.signal_distance, fits=True)
    if state.track is None or changed:
        evidence.append(said)
        track = begun(match.xy_m, noise, bias_m2, now_s, settings.track, state.track)
        return replace(state, track=track, rivalry=None, search=HeadingSearch(), phases=Phases())

    first = tested(replace(state.track, bias_variance_m2=bias_m2), match, noise, scan.time_s, moved, settings)
    checks.append(first.check)
    evidence.append(replace(said, fits=first.fits))
    state = _judged(state, first, match, noise, bias_m2, scan.time_s, moved, settings)
    if state.track is not None and not state.track.headed:
        track, search = sought(state.track, state.search)
        state = replace(state, track=track, search=search)
    return state


def _judged(
    state: SurefixState,
    first: TestedFix,
    match: Match,
    noise: FloatArray,
    bias_m2: float,
    time_s: float,
    moved: PdrOutput,
    settings: SurefixSettings,
) -> SurefixState:
    """The state after a scan has been tested against both accounts."""
    if state.track is None or state.time_s is None:
        raise RuntimeError("a scan is tested against a track")
    rivalry, limits = state.rivalry, settings.hypotheses
    if state.prior_only:
        limits = limits.beside_a_prior()
    track = first.fused if first.fits else state.track
    if rivalry is None:
        if first.fits:
            return replace(state, track=track, prior_only=False, phases=phases_of(first, int(first.corrected), 0, 0))
        begin = begun(match.xy_m, noise, bias_m2, state.time_s, settings.track, state.track)
        rivalry = Rivalry(begin, fault=limits.fault_after <= 1)
        return replace(state, rivalry=rivalry, phases=phases_of(first, 1, 1, int(rivalry.fault)))

    other = tested(replace(rivalry.rival, bias_variance_m2=bias_m2), match, noise, time_s, moved, settings)
    rivalry = judged(rivalry, first.fits, other.fits, limits)
    if other.fits:
        rivalry = replace(rivalry, rival=other.fused)
    elif not first.fits and not rivalry.taken_over:  # unlike both: if anywhere, the walker is at a third place
        begin = begun(match.xy_m, noise, bias_m2, state.time_s, settings.track, state.track)
        rivalry = replace(rivalry, rival=begin, for_rival=1, walked_m=0.0)
    if rival_wins(rivalry, limits):
        phases = phases_of(other, 1, 0, 1)
        return replace(
            state, track=rivalry.rival, rivalry=exchanged(rivalry, track), search=HeadingSearch(), phases=phases
        )
    if first_is_back(rivalry, limits):
        phases = phases_of(first, int(first.corrected), 0, 0)
        return replace(state, track=track, rivalry=None, prior_only=False, phases=phases)
    phases = phases_of(first, 1, int(not first.fits), int(rivalry.fault))
    return replace(state, track=track, rivalry=rivalry, phases=phases)


def _fix(state: SurefixState, moved: PdrOutput, settings: SurefixSettings, checks: tuple[InnovationCheck, ...]) -> Fix:
    track = state.track
    if track is None or state.floor is None or state.radio_s is None or state.time_s is None:
        walker = Walker(None, None, state.step_count, moved.motion, moved.carrying)
        return no_fix(state.start, state.time_s, walker)
    heading_rad = float(track.mean[ukf.HEADING]) if track.headed else None
    walker = Walker(heading_rad, speed_mps(track, moved), state.step_count, moved.motion, moved.carrying)
    xy_m, covariance = place(track, moved)
    tail = settings.tail_at(state.start.risk)
    estimate = Estimate(Position(float(xy_m[0]), float(xy_m[1]), state.floor.floor), covariance, tail)
    phases = state.phases
    if state.rivalry is not None:
        rival_m, rival_m2 = place(state.rivalry.rival, moved)
        reach_m = float(np.hypot(*(rival_m - xy_m))) + protection_level_m(rival_m2, state.start.risk, tail)
        phases = replace(phases, covers_m=reach_m)
    coasting = state.time_s - state.radio_s > settings.silent_after_s
    certain = state.floor.certainty >= settings.least_floor_certainty
    fix = assembled_fix(state.start, state.time_s, estimate, walker, phases, coasting, checks)
    return fix if certain else replace(fix, integrity=replace(fix.integrity, usable=False))


def surefix(method: str = "surefix", settings: SurefixSettings | None = None) -> Method:
    """The method with these settings."""
    return Method(method, start, partial(advance, settings=settings or SurefixSettings()))


SUREFIX = surefix()
