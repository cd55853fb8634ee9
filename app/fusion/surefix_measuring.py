"""How `surefix` tests a fix against an account of the walk, and fuses it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.estimation.arrays import FloatArray
from app.estimation.innovation import normalised_square
from app.estimation.unscented_kalman import correct, gain_of
from app.fusion import walking_ukf as ukf
from app.fusion.fix_assembly import Phases
from app.fusion.integrity_measuring import BY_WIFI
from app.fusion.surefix_settings import SurefixSettings
from app.fusion.walking_track import Track, ahead_m
from app.observations import Excluded, InnovationCheck
from app.pdr.tracker import PdrOutput
from app.wifi.match import Match


@dataclass(frozen=True, slots=True, eq=False)
class TestedFix:
    """A fix beside a track: how far off it is, whether it fits, and the track with it fused."""

    apart_m: float
    statistic: float
    fits: bool
    corrected: bool
    fused: Track
    check: InnovationCheck


def tested(
    track: Track, match: Match, noise: FloatArray, time_s: float, moved: PdrOutput, settings: SurefixSettings
) -> TestedFix:
    """Test a fix against a track, and fuse it: one that is a little far off is weighed down to where it just fits."""
    alpha = settings.track.alpha
    expectation = ukf.expect(
        track.mean, track.covariance, match.xy_m, noise, BY_WIFI, track.mean[:3], ahead_m(track, moved), alpha
    )
    innovation, spread, cross, gain = expectation
    statistic = normalised_square(innovation, spread)
    corrected = statistic > settings.corrected_above
    if corrected:
        spread = spread * (statistic / settings.corrected_above)
        gain = gain_of(cross, spread)
    angles = ukf.angles_of_state(len(track.mean))
    mean, covariance = correct(track.mean, track.covariance, innovation, spread, cross, gain, angles)
    fits = statistic <= settings.hypotheses.contradicts
    sigma = np.sqrt(np.diag(expectation[1]))
    check = InnovationCheck(
        "wifi", time_s, innovation, sigma, statistic, settings.hypotheses.contradicts, not fits, fits
    )
    fused = replace(track, mean=mean, covariance=covariance)
    return TestedFix(float(np.hypot(*innovation)), statistic, fits, corrected, fused, check)


def phases_of(first: TestedFix, if1: int, if2: int, if3: int) -> Phases:
    """What a scan's test means for the Fix."""
    excluded: tuple[Excluded, ...] = ()
    if if2:
        times = "again and again" if if3 else "this once"
        excluded = (Excluded(f"{first.apart_m:.0f} m from where the steps lead, {times}", observation="wifi"),)
    return Phases(if1, if2, if3, first.statistic, first.check.threshold, 0.0, excluded)
