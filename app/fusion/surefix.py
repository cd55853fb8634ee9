"""`surefix`, the default: what measured best of the published methods, and integrity that none of them has.

Steps move a cloud of particles that walls stop; it also learns the walker's step length, direction, and the slowly
varying error of the WiFi fixes around (app/fusion/particle_cloud.py). Fixes are soft matches over a smoothed map, each
with the variance that this building's survey taught (app/wifi/fix_calibration.py). A fix that steps cannot have led to
begins a rival track (app/fusion/hypotheses.py). docs/methods/surefix.md says what each part measured.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np

from app.floorplan.free_space import NO_PLAN, FreeSpace
from app.fusion.access_point_watch import AccessPointWatch, excluded, not_relied_on, trusted, watched
from app.fusion.advancing import Findings, advanced
from app.fusion.batch_events import Event, knows_turns
from app.fusion.beacon_fixes import with_beacons
from app.fusion.cloud_place import heading_of, place, scale_of
from app.fusion.facing import faced, placed
from app.fusion.fix_assembly import Estimate, Phases, Walker, assembled_fix, no_fix
from app.fusion.floor_choice import floor_before
from app.fusion.hearing import after, match_heard
from app.fusion.hypotheses import Rivalry, exchanged, first_is_back, judged, rival_wins
from app.fusion.interface import START_SIGMA_M, Method, SessionStart, Site
from app.fusion.particle_cloud import Cloud, aged, begun, stepped
from app.fusion.storeys import climbed, heard
from app.fusion.surefix_measuring import CloudFix, TestedFix, beginning, foreign_told, once_each, phases_of, tested
from app.fusion.surefix_settings import SurefixSettings
from app.fusion.surefix_state import SurefixState, on_next_floor
from app.integrity.protection_level import NOWHERE_SAFE
from app.observations import Batch, Fix, InnovationCheck, Position, WifiScan
from app.pdr.tracker import PdrOutput, initial_pdr_state
from app.pdr.turn_doubt import led
from app.wifi.fix_calibration import DEFAULT, calibration_of
from app.wifi.readings import is_news


def start(session: SessionStart) -> SurefixState:
    """The state of a session that has reported nothing."""
    return SurefixState(session, initial_pdr_state())


def advance(state: SurefixState, batch: Batch, site: Site, settings: SurefixSettings) -> tuple[SurefixState, Fix]:
    """The state after a batch, and the best estimate at its end."""

    def after(state: SurefixState, event: Event, findings: Findings) -> SurefixState:
        findings.evidence.extend(event.moved.steps)
        state = _moved(state, event, site, settings)
        storeys, floor, moved_on = climbed(state.storeys, state.floor, batch.barometer, event.time_s, site)
        state = replace(state, storeys=storeys, floor=floor)
        if moved_on:
            state = on_next_floor(state, settings.stairs_sigma_m)
        if event.scan is not None:
            watch, scan = trusted(state.watch, event.scan, site, settings.access_points)
            state = _scanned(replace(state, watch=watch), scan, event.moved, site, settings, findings)
            state = _watched(state, event, site, settings, findings)
        elif event.beacons is not None:
            state = with_beacons(state, event.beacons, event.moved, site, settings, findings)
        return state

    return advanced(state, batch, after, partial(_fix, site=site, settings=settings), bluetooth=True)


def _watched(
    state: SurefixState, event: Event, site: Site, settings: SurefixSettings, findings: Findings
) -> SurefixState:
    """The state after a scan was held against the map where the track is. While another account rivals nothing is
    learnt, and once it has taken over what was learnt is forgotten."""
    scan, track, floor, rivalry = event.scan, state.track, state.floor, state.rivalry
    if scan is None or track is None or floor is None or state.radio_s != scan.time_s or state.prior_only:
        return state
    if rivalry is not None:
        return replace(state, watch=AccessPointWatch()) if rivalry.taken_over else state
    at = place(track, event.moved)
    place_m = at.xy_m, at.covariance_m2
    watch, confirmed = watched(state.watch, scan, site, floor.decided, place_m, settings.access_points)
    findings.confirmed.extend(confirmed.tolist())
    return replace(state, watch=watch)


def _moved(state: SurefixState, event: Event, site: Site, settings: SurefixSettings) -> SurefixState:
    """Steps and time that passed since the event before, for both accounts."""
    track, rivalry, space = state.track, state.rivalry, _space(state, site)
    record, steps = led(state.turns, event.moved.steps, knows_turns(event))
    facing, steps = faced(state.facing, steps, settings.facing)
    state = replace(state, turns=record, facing=facing, step_count=state.step_count + len(steps))
    prior_m, variance_m2 = state.start.prior_m, START_SIGMA_M**2
    if track is None and prior_m is not None and event.time_s is not None:
        track = begun(prior_m, variance_m2, variance_m2, event.time_s, space, settings.cloud, by_wifi=False)
        state = replace(state, prior_only=True)

    def walked(cloud: Cloud) -> Cloud:
        for one in steps:
            cloud = stepped(cloud, one, space, settings.cloud)
        return cloud if event.time_s is None else aged(cloud, event.time_s, event.moved, settings.cloud)

    track = None if track is None else walked(track)
    if rivalry is not None:
        rival = walked(rivalry.rival)
        way_m = scale_of(rival) * sum(step.length_m for step in event.moved.steps)
        rivalry = replace(rivalry, rival=rival, walked_m=rivalry.walked_m + way_m)
    return replace(state, pdr=event.pdr, time_s=event.time_s, track=track, rivalry=rivalry)


def _space(state: SurefixState, site: Site) -> FreeSpace:
    """Where the phone can be on the floor that it is taken to be on."""
    floor = floor_before(state.floor, state.start.floor_hint)
    return NO_PLAN if floor is None else site.space(floor)


def _scanned(
    state: SurefixState,
    scan: WifiScan,
    moved: PdrOutput,
    site: Site,
    settings: SurefixSettings,
    findings: Findings,
) -> SurefixState:
    now_s = state.time_s
    if site.radio_map is None or now_s is None:
        return state
    hearing = after(state.hearing, scan, settings.hearing)
    unheeded, state = not_relied_on(state.watch, site), replace(state, hearing=hearing)
    known = partial(match_heard, site.radio_map, scan, hearing, unheeded, settings.least_known, settings.hearing)
    found = known()
    if found is None or (state.track is None and found.match.signal_distance >= settings.unlike):
        return state
    hint = state.start.floor_hint
    unlike = found.strange.unlike
    storeys, floor = heard(state.storeys, state.floor, hint, site.radio_map, site, found.match, unlike, now_s)
    if floor.decided != found.match.floor:
        found = known(floor.floor)
        if found is None:
            return state
    match = found.match
    changed = floor.floor != floor_before(state.floor, hint)
    calibration = calibration_of(site.radio_map)
    variance_m2 = calibration.variance_m2(match, settings.distance_weight)
    lasting_m2 = settings.lasting * calibration.persistence * variance_m2
    elsewhere_m = site.radio_map.xy_m[match.alike(settings.alike)]
    own_m2, place_m = variance_m2 - lasting_m2, calibration.place_m(match)
    fix = CloudFix(place_m, own_m2, lasting_m2, scan.time_s, elsewhere_m=elsewhere_m)
    # a track that beacons began is no better than the first scan of WiFi
    by_beacons = state.radio_s is None and not state.prior_only
    believed = not state.prior_only and (state.rivalry is None or not state.rivalry.fault)
    facing, turned = placed(state.facing, place_m, variance_m2, believed, settings.facing)
    state = replace(state, floor=floor, storeys=storeys, radio_s=scan.time_s, otherwise_m=found.otherwise_m)
    newest_m2 = settings.distance_weight * calibration.strange_m2(found.strange)
    state = replace(state, facing=facing, strange_m2=settings.strange_m2(state.strange_m2, newest_m2))
    if changed and storeys.changing and state.track is not None:
        state, changed = on_next_floor(state, settings.stairs_sigma_m), False
    said = fix.said(floor.floor, match.signal_distance)
    if state.track is None or changed or by_beacons or turned:
        findings.evidence.append(said)
        track = beginning(fix, now_s, _space(state, site), settings, state.track)
        phases = Phases(excluded=foreign_told(found))
        return replace(state, track=track, rivalry=None, prior_only=False, phases=phases)
    first = tested(state.track, fix, moved, _space(state, site), settings)
    findings.checks.append(first.check)
    findings.evidence.append(replace(said, fits=first.fits))
    limits, explained = settings.hypotheses, False
    if not first.fits:
        here_m = place(state.track, moved).xy_m
        explained = found.less_like(site.radio_map, here_m, limits.here_m) < limits.unlike_here
    state = _judged(state, first, fix, scan, moved, _space(state, site), settings, explained)
    return replace(state, phases=replace(state.phases, excluded=state.phases.excluded + foreign_told(found)))


def _judged(
    state: SurefixState,
    first: TestedFix,
    fix: CloudFix,
    scan: WifiScan,
    moved: PdrOutput,
    space: FreeSpace,
    settings: SurefixSettings,
    explained: bool,
) -> SurefixState:
    """The state after a scan has been tested against both accounts. explained : as of `judged`."""
    if state.track is None or state.time_s is None:
        raise RuntimeError("a scan is tested against a track")
    rivalry, limits = state.rivalry, settings.hypotheses
    if state.prior_only:
        limits = limits.beside_a_prior()
    track = first.fused
    if rivalry is None:
        if first.fits:
            return replace(state, track=track, prior_only=False, phases=phases_of(first, int(first.corrected), 0, 0))
        rival = beginning(fix, state.time_s, space, settings, state.track)
        nothing_yet = Rivalry(rival, scan.time_s, contradictions=0, for_rival=0)
        rivalry = judged(nothing_yet, first.statistic, False, True, scan.time_s, limits, explained)
        return replace(state, rivalry=rivalry, phases=phases_of(first, 1, 1, int(rivalry.fault)))
    other = tested(rivalry.rival, fix, moved, space, settings)
    if state.prior_only or is_news(scan, rivalry.witness_s):
        rivalry = judged(rivalry, first.statistic, first.fits, other.fits, scan.time_s, limits, explained)
    rivalry = replace(rivalry, rival=other.fused)
    if not other.fits and not first.fits and not rivalry.taken_over:
        # unlike both: if anywhere, the walker is at a third place
        rival = beginning(fix, state.time_s, space, settings, state.track)
        rivalry = replace(rivalry, rival=rival, for_rival=1, walked_m=0.0)
    if rival_wins(rivalry, limits):
        phases = phases_of(other, 1, 0, 1)
        return replace(state, track=rivalry.rival, rivalry=exchanged(rivalry, track), phases=phases)
    if first_is_back(rivalry, limits):
        phases = phases_of(first, int(first.corrected), 0, 0)
        return replace(state, track=track, rivalry=None, prior_only=False, phases=phases)
    phases = phases_of(first, 1, int(not first.fits), int(rivalry.fault))
    return replace(state, track=track, rivalry=rivalry, phases=phases)


def _fix(
    state: SurefixState, moved: PdrOutput, checks: tuple[InnovationCheck, ...], site: Site, settings: SurefixSettings
) -> Fix:
    track, risk = state.track, state.start.risk
    if track is None or state.floor is None or state.heard_s is None or state.time_s is None:
        return no_fix(state.start, state.time_s, Walker.of(moved, state.step_count))
    stride_m = scale_of(track) * track.stride_m
    walker = Walker.of(moved, state.step_count, heading_of(track), stride_m, track.stride_s)
    here, learnt = place(track, moved), DEFAULT if site.radio_map is None else calibration_of(site.radio_map)
    strange_m2 = state.strange_m2 or 0.0
    own_m = level_m = settings.level_m(here, strange_m2, risk, learnt)
    if state.rivalry is not None:
        there = place(state.rivalry.rival, moved)
        apart_m = float(np.hypot(*(there.xy_m - here.xy_m)))
        level_m = max(level_m, apart_m + settings.level_m(there, strange_m2, risk, learnt))
    if state.otherwise_m is not None:
        level_m = max(level_m, math.dist(state.otherwise_m, here.xy_m) + own_m)
    certain = state.floor.certainty >= settings.least_floor_certainty and not state.storeys.changing
    if not certain:
        level_m = max(level_m, NOWHERE_SAFE * state.start.alert_limit_m)
    position = Position(float(here.xy_m[0]), float(here.xy_m[1]), state.floor.floor)
    spread_m2 = settings.covariance_m2(here, strange_m2, learnt)
    estimate = Estimate(position, spread_m2, accuracy_m=settings.accuracy_m(here, strange_m2, learnt), level_m=level_m)
    told = once_each(state.phases.excluded, excluded(state.watch, settings.access_points))
    phases = replace(state.phases, excluded=told)
    coasting = state.time_s - state.heard_s > settings.silent_after_s
    fix = assembled_fix(state.start, state.time_s, estimate, walker, phases, coasting, checks)
    return replace(fix, floor_certain=certain, unsurveyed_m2=settings.beyond_m2(strange_m2))


def surefix(method: str = "surefix", settings: SurefixSettings | None = None) -> Method:
    """The method with these settings."""
    return Method(method, start, partial(advance, settings=settings or SurefixSettings()), walls=True)


SUREFIX = surefix()
