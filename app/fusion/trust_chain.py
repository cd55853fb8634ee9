"""Method E, `trust_chain`: steps from one trusted fix to the next, WiFi the more the longer none was trusted.

Trust Chain Positioning Fusion, Sensors 2015, 15, 29850; docs/methods/trust_chain.md says what differs and why, and
what was measured.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from app.fusion.advancing import Findings, advanced
from app.fusion.batch_events import Event
from app.fusion.chain import Chain, aged, ahead_m, begun, fused, north_found, stepped
from app.fusion.fix_assembly import Phases, Walker, fix_at, no_fix
from app.fusion.fix_trial import tried
from app.fusion.floor_choice import chosen_floor, floor_before
from app.fusion.interface import START_SIGMA_M, Method, SessionStart, Site
from app.fusion.scan_matching import HEAVY_TAILS, said
from app.fusion.state_codec import storable
from app.fusion.trust_chain_settings import Fusion, TrustChainSettings
from app.fusion.trust_state import Trust, state_after, weight_of, within_trusted_area
from app.observations import Batch, Fix, InnovationCheck, WifiScan
from app.pdr.motion_state import ShakingState, advance_shaking
from app.pdr.tracker import PdrOutput, PdrState, initial_pdr_state
from app.wifi.floor_decision import FloorBelief
from app.wifi.match import Match
from app.wifi.moving_signals import candidates_of, loud_readings, match_among, on_floor
from app.wifi.radio_map import RadioMap
from app.wifi.readings import fresh_readings
from app.wifi.strongest_wknn import strongest_wknn


@storable
@dataclass(frozen=True, slots=True, eq=False)
class TrustChainState:
    """Of one session. radio_s : newest usable scan; there is no position before the first.

    shaking : whether the phone is still, by this paper's signs.  streak : failed tests of WiFi in a row.
    phases : what the newest test found.
    """

    start: SessionStart
    pdr: PdrState
    shaking: ShakingState = field(default_factory=ShakingState)
    floor: FloorBelief | None = None
    phases: Phases = field(default_factory=Phases)
    time_s: float | None = None
    chain: Chain | None = None
    radio_s: float | None = None
    streak: int = 0
    step_count: int = 0


storable(ShakingState)


def start(session: SessionStart) -> TrustChainState:
    """The state of a session that has reported nothing."""
    return TrustChainState(session, initial_pdr_state())


def advance(
    state: TrustChainState, batch: Batch, site: Site, settings: TrustChainSettings
) -> tuple[TrustChainState, Fix]:
    """The state after a batch, and the best estimate at its end."""

    def after(state: TrustChainState, event: Event, findings: Findings) -> TrustChainState:
        findings.evidence.extend(event.moved.steps)
        until_s = None if event.scan is None else event.scan.time_s
        state = replace(state, shaking=advance_shaking(state.shaking, batch, until_s))
        state = _moved(state, event, settings)
        return state if event.scan is None else _scanned(state, event.scan, event.moved, site, settings, findings)

    return advanced(state, batch, after, partial(_fix, settings=settings))


def _moved(state: TrustChainState, event: Event, settings: TrustChainSettings) -> TrustChainState:
    """Steps and time that passed since the event before."""
    chain, moved = state.chain, event.moved
    if settings.fusion is Fusion.WIFI_ONLY:
        moved = replace(moved, steps=(), inertial_until_s=None)
    if chain is None and state.start.prior_m is not None and event.time_s is not None:
        chain = begun(state.start.prior_m, START_SIGMA_M, event.time_s)
    if chain is not None:
        for step in moved.steps:
            chain = stepped(chain, step, event, settings)
        if event.time_s is not None:
            chain = aged(chain, event.time_s, moved)
    steps = state.step_count + len(event.moved.steps)
    return replace(state, pdr=event.pdr, time_s=event.time_s, chain=chain, step_count=steps)


def _scanned(
    state: TrustChainState,
    scan: WifiScan,
    moved: PdrOutput,
    site: Site,
    settings: TrustChainSettings,
    findings: Findings,
) -> TrustChainState:
    radio_map, now_s = site.radio_map, state.time_s
    if radio_map is None or now_s is None:
        return state
    loud = loud_readings(fresh_readings(scan), state.shaking.still, settings.signal)
    points = candidates_of(radio_map, loud, settings.signal)
    match = match_among(radio_map, loud, points, settings.signal)
    if match is None or match.known < settings.least_known:
        return state
    hint = state.start.floor_hint
    floor = chosen_floor(state.floor, hint, radio_map, site, match)
    if floor.decided != match.floor:
        match = match_among(radio_map, loud, points, settings.signal, floor.decided)
        if match is None:
            return state
    changed = floor.floor != floor_before(state.floor, hint)
    state = replace(state, floor=floor, radio_s=scan.time_s)
    chain = state.chain
    if chain is None or changed:
        findings.evidence.append(said(scan, floor.floor, match, HEAVY_TAILS * settings.fix_sigma_m**2, fits=True))
        return replace(state, chain=begun(match.xy_m, settings.fix_sigma_m, now_s), streak=0, phases=Phases())

    steps_m = chain.at_m + ahead_m(chain, moved)
    spread_m2 = (chain.sigma_m**2 + settings.fix_sigma_m**2) * np.eye(2)
    seen = tried(scan.time_s, match.xy_m - steps_m, spread_m2, state.streak, settings.trial)
    findings.checks.append(seen.check)
    findings.evidence.append(said(scan, floor.floor, match, HEAVY_TAILS * settings.fix_sigma_m**2, seen.passed))
    if seen.fault:
        chain = begun(match.xy_m, settings.fix_sigma_m, now_s)
        return replace(state, chain=chain, streak=0, phases=seen.phases)
    trusted = bool(within_trusted_area(match.xy_m[np.newaxis], chain.last_m, steps_m, settings)[0])
    trust = state_after(chain.trust, chain.mistrust, trusted, settings)
    weight = 0.0
    if seen.passed:
        weight = _weight(chain, trusted, settings)
        if trust is not Trust.UNLOCKED:
            match = _filtered(match, radio_map, loud, points, chain.last_m, steps_m, settings)
    chain = fused(chain, match.xy_m - steps_m, weight, trusted, trust, settings)
    return replace(state, chain=north_found(chain), streak=seen.streak, phases=seen.phases)


def _weight(chain: Chain, trusted: bool, settings: TrustChainSettings) -> float:
    """Of a fix against the steps."""
    match settings.fusion:
        case Fusion.WIFI_ONLY:
            return 1.0
        case Fusion.CROSS_ASSISTIVE:
            return float(trusted)
        case _:
            return weight_of(chain.mistrust)


def _filtered(
    match: Match,
    radio_map: RadioMap,
    loud: WifiScan,
    points: IntArray | None,
    last_m: FloatArray,
    steps_m: FloatArray,
    settings: TrustChainSettings,
) -> Match:
    """The match of the candidates in the trusted area alone; as it was where there is none."""
    if settings.fusion is Fusion.WIFI_ONLY:
        return match
    near = on_floor(radio_map, points, match.floor)
    near = near[within_trusted_area(radio_map.xy_m[near], last_m, steps_m, settings)]
    if not len(near):
        return match
    inside = strongest_wknn(radio_map, loud.bssid, loud.rssi_dbm, settings.signal.wknn, match.floor, near)
    return match if inside is None else inside


def _fix(
    state: TrustChainState, moved: PdrOutput, checks: tuple[InnovationCheck, ...], settings: TrustChainSettings
) -> Fix:
    chain = state.chain
    if chain is None:
        return no_fix(state.start, state.time_s, Walker.of(moved, state.step_count))
    walker = Walker.of(moved, state.step_count, chain.heading_rad, chain.stride_m, chain.stride_s)
    spread_m2 = (chain.sigma_m**2 + settings.lasting_m2) * np.eye(2)
    return fix_at(state, chain.at_m + ahead_m(chain, moved), spread_m2, walker, settings, checks)


def trust_chain(method: str = "trust_chain", settings: TrustChainSettings | None = None) -> Method:
    """The method with these settings."""
    return Method(method, start, partial(advance, settings=settings or TrustChainSettings()))


TRUST_CHAIN = trust_chain()
