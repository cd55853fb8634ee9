"""How `surefix` tests a fix against an account of the walk, and fuses it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from app.estimation.arrays import FloatArray
from app.estimation.innovation import normalised_square
from app.floorplan.free_space import FreeSpace
from app.fusion.cloud_fusing import expected, fused
from app.fusion.fix_assembly import Phases, taken_out
from app.fusion.hearing import HeardMatch
from app.fusion.particle_cloud import NOWHERE, Cloud, begun
from app.fusion.surefix_settings import SurefixSettings
from app.observations import Excluded, InnovationCheck, RadioFix
from app.pdr.tracker import PdrOutput


@dataclass(frozen=True, slots=True, eq=False)
class CloudFix:
    """Where one scan alone puts the phone.

    xy_m : (2,).  own_m2, lasting_m2 : variances in each direction of what is this fix's own error, and of what it
    shares with the fixes of WiFi around it; lasting_m2 None of a fix that shares nothing with them.
    time_s : of the scan.  source : of the check that it leaves.
    elsewhere_m : (k, 2) other places that the scan is like.
    """

    xy_m: FloatArray
    own_m2: float
    lasting_m2: float | None
    time_s: float
    source: str = "wifi"
    elsewhere_m: FloatArray = field(default_factory=lambda: NOWHERE)

    def said(self, floor: str, signal_distance: float) -> RadioFix:
        """The fix as evidence."""
        noise = self.own_m2 * np.eye(2)
        lasting_m2 = self.lasting_m2 or 0.0
        return RadioFix(
            self.time_s, floor, self.xy_m, noise, lasting_m2, signal_distance, fits=True, source=self.source
        )


@dataclass(frozen=True, slots=True, eq=False)
class TestedFix:
    """A fix beside a track: how far off it is, whether it fits, and the track, with the fix in it if it does."""

    apart_m: float
    statistic: float
    fits: bool
    corrected: bool
    fused: Cloud
    check: InnovationCheck


def beginning(fix: CloudFix, now_s: float, space: FreeSpace, settings: SurefixSettings, earlier: Cloud | None) -> Cloud:
    """A track that begins at a fix. earlier : one given up."""
    by_wifi = fix.lasting_m2 is not None
    lasting_m2 = fix.own_m2 if fix.lasting_m2 is None else fix.lasting_m2
    return begun(fix.xy_m, fix.own_m2, lasting_m2, now_s, space, settings.cloud, earlier, by_wifi, fix.elsewhere_m)


def tested(
    track: Cloud,
    fix: CloudFix,
    moved: PdrOutput,
    space: FreeSpace,
    settings: SurefixSettings,
    caution: float = 1.0,
) -> TestedFix:
    """Test a fix against a track, and fuse it where it fits: one a little far off is weighed down to where it does.

    caution : by what its variance counts more once it has been tested.
    """
    mean, covariance = expected(track, moved, by_wifi=fix.lasting_m2 is not None)
    innovation, spread = fix.xy_m - mean, covariance + fix.own_m2 * np.eye(2)
    statistic, threshold = float(normalised_square(innovation, spread)), settings.hypotheses.contradicts
    fits, corrected = statistic <= threshold, statistic > settings.corrected_above
    check = InnovationCheck(
        fix.source, fix.time_s, innovation, np.sqrt(np.diag(spread)), statistic, threshold, not fits, fits
    )
    if fits:
        weakened = statistic / settings.corrected_above if corrected else 1.0
        track = fused(track, fix.xy_m, caution * fix.own_m2, fix.lasting_m2, weakened, moved, space, settings.cloud)
    return TestedFix(float(np.hypot(*innovation)), statistic, fits, corrected, track, check)


def phases_of(first: TestedFix, if1: int, if2: int, if3: int) -> Phases:
    """What a scan's test means for the Fix."""
    excluded: tuple[Excluded, ...] = ()
    if if2:
        excluded = (taken_out(first.apart_m, bool(if3)),)
    return Phases(if1, if2, if3, first.statistic, first.check.threshold, 0.0, excluded)


def foreign_told(found: HeardMatch) -> tuple[Excluded, ...]:
    """What of a scan was left out, and why."""
    reason = "foreign: nobody heard it where the rest of the scan was taken"
    return tuple(Excluded(reason, bssid=bssid) for bssid in found.foreign.tolist())


def once_each(by_scan: tuple[Excluded, ...], known: tuple[Excluded, ...]) -> tuple[Excluded, ...]:
    """Both, without what a scan says of access points that more is known of."""
    names = {one.bssid for one in known}
    return (*(one for one in by_scan if one.bssid is None or one.bssid not in names), *known)
