"""Bluetooth beacons in `surefix`: fixes of their own, beside WiFi's, and in its place where there is none.

Beside WiFi a fix by beacons only pulls: it is fused into every account of the walk that it fits, decides nothing
between them, and one that fits none is left out. Where no WiFi scan has been usable for a while beacons carry the
session: they begin the track, decide the floor, and contradict it as WiFi would.

Their errors have nothing in common with the lasting error of WiFi fixes, so they are fused as places, and their own
lasting error is accounted for by counting each for less.
"""

from __future__ import annotations

from dataclasses import replace

from app.estimation.arrays import FloatArray, IntArray
from app.floorplan.free_space import FreeSpace
from app.fusion.advancing import Findings
from app.fusion.beacon_listening import listened
from app.fusion.fix_assembly import Phases, taken_out
from app.fusion.floor_choice import floor_before
from app.fusion.interface import Site
from app.fusion.storeys import heard
from app.fusion.surefix_measuring import CloudFix, TestedFix, beginning, tested
from app.fusion.surefix_settings import SurefixSettings
from app.fusion.surefix_state import SurefixState, on_next_floor
from app.observations import BluetoothScan
from app.pdr.tracker import PdrOutput
from app.wifi.beacons import BEACON_MATCH
from app.wifi.fix_calibration import BEACON_DEFAULT, calibration_of
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap
from app.wifi.soft_match import soft_match

FLOOR_DOUBT = 0.4
"""Share of a fix's vote for its floor that any floor gets: of the mall's, each by itself, 1 in 30 is of a wrong one."""


def with_beacons(
    state: SurefixState,
    scan: BluetoothScan,
    moved: PdrOutput,
    site: Site,
    settings: SurefixSettings,
    findings: Findings,
) -> SurefixState:
    """The state after beacons were heard; the same state on a map that knows none."""
    if site.radio_map is None or site.radio_map.beacons is None or state.time_s is None:
        return state
    beacons, now_s = site.radio_map.beacons, state.time_s
    ear, told = listened(state.ear, scan, now_s)
    state = replace(state, ear=ear)
    if told is None:
        return state
    alone = state.radio_s is None or now_s - state.radio_s > settings.silent_after_s
    storeys, floor, match = state.storeys, state.floor, None
    if alone:
        match = soft_match(beacons, *told, BEACON_MATCH)
        if match is not None:
            hint, doubted = state.start.floor_hint, _doubted(match)
            storeys, floor = heard(storeys, floor, hint, beacons, site, doubted, match.unlike, now_s)
    if floor is not None and (match is None or beacons.floors[match.floor] != floor.floor):
        match = _on_floor(beacons, told, floor.floor)
    if match is None or floor is None or (state.track is None and not _begins(match, site.radio_map, settings)):
        return state
    changed = floor.floor != floor_before(state.floor, state.start.floor_hint)
    fix = CloudFix(
        match.xy_m, calibration_of(beacons, BEACON_DEFAULT).variance_m2(match), None, now_s, source="bluetooth"
    )
    caution = settings.beacon_caution_alone if alone else settings.beacon_caution
    state = replace(state, floor=floor, storeys=storeys)
    if changed and storeys.changing and state.track is not None:
        state, changed = on_next_floor(state, settings.stairs_sigma_m), False
    said = replace(fix, own_m2=caution * fix.own_m2).said(floor.floor, match.signal_distance)
    space = site.space(floor.floor)
    if state.track is None or changed:
        findings.evidence.append(said)
        return _begun(state, fix, space, settings, caution, Phases())
    first = tested(state.track, fix, moved, space, settings, caution)
    findings.checks.append(first.check)
    findings.evidence.append(replace(said, fits=first.fits))
    if alone and state.rivalry is None:
        return _carried(state, first, fix, space, settings, caution)
    return _pulled(state, first, fix, moved, space, settings, caution)


def _begins(match: Match, radio_map: RadioMap, settings: SurefixSettings) -> bool:
    """Whether a position may begin at a fix: few beacons may do so only where no WiFi will come to say it better."""
    few = match.known < settings.least_known and len(radio_map.bssid) > 0
    return not few and match.signal_distance < settings.unlike


def _doubted(match: Match) -> Match:
    """The match with less of a vote for its floor."""
    votes = match.floor_probability
    return replace(match, floor_probability=(1.0 - FLOOR_DOUBT) * votes + FLOOR_DOUBT / len(votes))


def _on_floor(beacons: RadioMap, told: tuple[IntArray, FloatArray], floor: str) -> Match | None:
    if floor not in beacons.floors:
        return None
    return soft_match(beacons, *told, BEACON_MATCH, floor=beacons.floors.index(floor))


def _pulled(
    state: SurefixState,
    first: TestedFix,
    fix: CloudFix,
    moved: PdrOutput,
    space: FreeSpace,
    settings: SurefixSettings,
    caution: float,
) -> SurefixState:
    """Beside WiFi: into every account that it fits."""
    ear, rivalry = state.ear, state.rivalry
    if first.fits:
        ear = replace(ear, placed_s=fix.time_s, contradictions=0)
    if rivalry is not None:
        rivalry = replace(rivalry, rival=tested(rivalry.rival, fix, moved, space, settings, caution).fused)
    return replace(state, track=first.fused, rivalry=rivalry, ear=ear)


def _carried(
    state: SurefixState, first: TestedFix, fix: CloudFix, space: FreeSpace, settings: SurefixSettings, caution: float
) -> SurefixState:
    """In place of WiFi: what beacons contradict again and again is a fault, and given up in the end."""
    statistic, threshold = first.check.statistic, first.check.threshold
    if first.fits:
        ear = replace(state.ear, placed_s=fix.time_s, contradictions=0)
        phases = Phases(int(first.corrected), 0, 0, statistic, threshold)
        return replace(state, track=first.fused, ear=ear, prior_only=False, phases=phases)
    limits = settings.hypotheses.beside_a_prior() if state.prior_only else settings.hypotheses
    contradictions = state.ear.contradictions + 1
    fault = contradictions >= limits.fault_after
    excluded = (taken_out(first.apart_m, fault, "bluetooth"),)
    phases = Phases(1, 1, int(fault), statistic, threshold, first.apart_m, excluded)
    state = replace(state, ear=replace(state.ear, contradictions=contradictions), phases=phases)
    if contradictions < limits.moved_after:
        return state
    return _begun(state, fix, space, settings, caution, phases)


def _begun(
    state: SurefixState,
    fix: CloudFix,
    space: FreeSpace,
    settings: SurefixSettings,
    caution: float,
    phases: Phases,
) -> SurefixState:
    """The state with a track that begins at a fix by beacons."""
    fix = replace(fix, own_m2=caution * fix.own_m2)
    track = beginning(fix, fix.time_s, space, settings, state.track)
    ear = replace(state.ear, placed_s=fix.time_s, contradictions=0)
    return replace(state, track=track, rivalry=None, prior_only=False, phases=phases, ear=ear)
