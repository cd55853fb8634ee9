"""Settings of method E, with where each default comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from enum import StrEnum

from app.fusion.fix_trial import TrialSettings
from app.wifi.moving_signals import PLAIN, SignalSettings


class Fusion(StrEnum):
    """How WiFi and steps are joined: the trust chain, or what the paper compares it with."""

    TRUST_CHAIN = "trust_chain"
    CROSS_ASSISTIVE = "cross_assistive"
    WIFI_ONLY = "wifi_only"


@dataclass(frozen=True, slots=True)
class TrustChainSettings:
    """Of the method.

    fusion : see there.  signal : of the matching.
    distance_m, bearing_rad : tolerances of the trusted area, Eq. 15; the paper's 2 m and 45 degrees.
    step_error : error of dead reckoning per metre, the paper's 0.0897 m of 0.75 m.  fix_error_m : mean error of a fix,
    the unit of TC, a property of the site: the paper's 2.68, on the mall walks 7.2; ours stands between.
    unlocked_from : TC at which the chain is unlocked.
    most_mistrust : TC grows no further; a fix weighs 1 - 1 / 1001 then.
    trial : of the fixes.  fix_sigma_m, trusted_sigma_m : of a fix in each direction, by which it is tested and a chain
    begins, and of a trusted one.  step_sigma : growth of the position's standard deviation per metre.
    lasting_m2 : variance in each direction that no agreement takes away.
    These five are ours, the paper knows no covariance: from the errors on folds 1-4 of the mall walks, by trust state.
    least_known : access points known to the map with which a scan is usable.
    silent_after_s : without a usable scan for so long the track coasts.
    tail : protection level beside a Gaussian's of the same covariance.
    """

    fusion: Fusion = Fusion.TRUST_CHAIN
    signal: SignalSettings = field(default_factory=SignalSettings)
    distance_m: float = 2.0
    bearing_rad: float = math.pi / 4.0
    step_error: float = 0.0897 / 0.75
    fix_error_m: float = 4.0
    unlocked_from: float = 1.0
    most_mistrust: float = 1000.0
    trial: TrialSettings = field(default_factory=TrialSettings)
    fix_sigma_m: float = 5.0
    trusted_sigma_m: float = 3.2
    step_sigma: float = 0.08
    lasting_m2: float = 4.0
    least_known: int = 3
    silent_after_s: float = 8.0
    tail: float = 1.6


_OURS = TrustChainSettings()
_WIFI = replace(_OURS, fusion=Fusion.WIFI_ONLY, trial=TrialSettings(tested=False))
TRUST_CHAIN_ABLATIONS: dict[str, TrustChainSettings] = {
    "trust_chain_cross_assistive": replace(_OURS, fusion=Fusion.CROSS_ASSISTIVE),
    "trust_chain_wifi_alone": _WIFI,
    "trust_chain_wifi_threshold": replace(_WIFI, signal=replace(_OURS.signal, ap_match=False)),
    "trust_chain_wifi_plain": replace(_WIFI, signal=PLAIN),
    "trust_chain_plain_signals": replace(_OURS, signal=PLAIN),
}
"""The rows of the paper's figures: WKNN, with the threshold, with AP match too, the algorithm that it is compared with;
and the chain on WKNN without either."""
