"""The parts of the methods alone, and their ablations: what a fused result is compared with."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.fusion.adaptive_robust_kf import adaptive_robust_kf
from app.fusion.adaptive_robust_settings import PAPER_NOISE, AdaptiveRobustSettings
from app.fusion.batch_events import end_of
from app.fusion.dual_settings import AS_PRINTED, PAPER_DIRECTION, DualSettings, Empirical, Filter
from app.fusion.dual_ukf import dual_ukf
from app.fusion.fix_assembly import Estimate, Phases, Walker, assembled_fix, no_fix
from app.fusion.integrity_settings import WEIBULL_ERROR, IntegritySettings
from app.fusion.integrity_ukf import integrity_ukf
from app.fusion.interface import Method, SessionStart, Site
from app.fusion.methods import METHODS
from app.fusion.scan_matching import Matcher, match_scan
from app.fusion.state_codec import storable
from app.fusion.trust_chain import trust_chain
from app.fusion.trust_chain_settings import TRUST_CHAIN_ABLATIONS
from app.fusion.two_stage_ekf import two_stage_ekf
from app.fusion.two_stage_settings import TWO_STAGE_ABLATIONS
from app.observations import Batch, Carrying, Fix, Motion, Position

SILENT_AFTER_S = 8.0
_OURS = IntegritySettings()
_DUAL = DualSettings()
_CONSTANT = DualSettings(empirical=Empirical())
_ROBUST = AdaptiveRobustSettings()
_NOBODY = Walker(None, None, 0, Motion.UNKNOWN, Carrying.UNKNOWN)


@storable
@dataclass(frozen=True, slots=True, eq=False)
class LastFix:
    """The newest scan's place and covariance (2, 2), as the matcher gave it."""

    start: SessionStart
    time_s: float | None = None
    radio_s: float | None = None
    position: Position | None = None
    covariance_m2: FloatArray | None = None


def _advance_wifi(state: LastFix, batch: Batch, site: Site) -> tuple[LastFix, Fix]:
    for scan in batch.wifi:
        match = match_scan(site.radio_map, scan, Matcher.WKNN, 1)
        if match is not None and site.radio_map is not None:
            position = Position(float(match.xy_m[0]), float(match.xy_m[1]), site.radio_map.floors[match.floor])
            spread = match.covariance_m2 + np.eye(2)
            state = replace(state, radio_s=scan.time_s, position=position, covariance_m2=spread)
    time_s = end_of(batch, state.time_s)
    state = replace(state, time_s=time_s)
    if state.position is None or state.covariance_m2 is None or time_s is None or state.radio_s is None:
        return state, no_fix(state.start, time_s, _NOBODY)
    coasting = time_s - state.radio_s > SILENT_AFTER_S
    estimate = Estimate(state.position, state.covariance_m2, 1.0)
    return state, assembled_fix(state.start, time_s, estimate, _NOBODY, Phases(), coasting, ())


WIFI_ALONE = Method("wifi_alone", LastFix, _advance_wifi)
"""Each scan's fix as it is, with its neighbours' scatter: what every fusion starts from."""


def by_name(methods: Iterable[Method]) -> dict[str, Method]:
    """The methods by their names.

    Raises
    ------
    ValueError : two of one name; the second would silently be measured in place of the first.
    """
    found: dict[str, Method] = {}
    for method in methods:
        if method.method in found:
            raise ValueError(f"two methods are called {method.method}")
        found[method.method] = method
    return found


ALONE = by_name(
    (
        WIFI_ALONE,
        integrity_ukf("pdr_alone", replace(_OURS, use_scans=False)),
        integrity_ukf("integrity_ukf_plain", replace(_OURS, monitor=replace(_OURS.monitor, monitored=False))),
        integrity_ukf("integrity_ukf_weibull", replace(_OURS, matcher=Matcher.WEIBULL_BAYES, error=WEIBULL_ERROR)),
        integrity_ukf("integrity_ukf_three_states", replace(_OURS, track=replace(_OURS.track, learning=False))),
        integrity_ukf("integrity_ukf_control_twice", replace(_OURS, control_twice=True)),
        integrity_ukf("integrity_ukf_literal_if3", replace(_OURS, monitor=replace(_OURS.monitor, literal_phase3=True))),
        dual_ukf("dual_ukf_empirical", _CONSTANT),
        dual_ukf("dual_ekf_empirical", replace(_CONSTANT, position_filter=Filter.EXTENDED)),
        dual_ukf("dual_kf_empirical", replace(_CONSTANT, position_filter=Filter.LINEAR)),
        dual_ukf("dual_pdr_alone", replace(_DUAL, use_scans=False)),
        dual_ukf("dual_wifi_alone", replace(_DUAL, use_steps=False)),
        dual_ukf("dual_ukf_rmpca", replace(_DUAL, direction=PAPER_DIRECTION)),
        dual_ukf("dual_ukf_as_printed", AS_PRINTED),
        adaptive_robust_kf("adaptive_robust_kf_standard", replace(_ROBUST, adaptive=False, robust=False)),
        adaptive_robust_kf("adaptive_robust_kf_adaptive", replace(_ROBUST, robust=False)),
        adaptive_robust_kf("adaptive_robust_kf_paper_noise", replace(_ROBUST, noise=PAPER_NOISE)),
        *(two_stage_ekf(name, settings) for name, settings in TWO_STAGE_ABLATIONS.items()),
        *(trust_chain(name, settings) for name, settings in TRUST_CHAIN_ABLATIONS.items()),
    )
)
"""Rows that `surefix evaluate --methods` may name beside the methods."""

ROWS = by_name((*METHODS.values(), *ALONE.values()))
"""What the commands may be asked to walk: the methods, and their parts alone to compare with."""
