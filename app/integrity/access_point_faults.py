"""What one scan says for or against each access point still standing where it was surveyed.

Where the phone is, the map says of every access point how often it is heard there and how loud. A reading, or the lack
of one, is weighed by how likely it is for an access point that is as surveyed, beside one that may be anywhere: the
logarithm of that ratio is the evidence, whatever the fault. What all access points of a scan have in common is the
phone's, the bearer's or the position's, and is taken out first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from app.estimation.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, slots=True)
class FaultEvidenceSettings:
    """Measured on folds 1-4 of the mall walks.

    least_scans : weight of survey scans around, below which nothing is known of a place.
    expected_share : an access point that this share of the scans around heard is expected; fewer than least_expected
    of those heard say nothing about what they have in common.
    noise_db, spread_share : of a reading, beside the map's spread around: noise_db^2 + spread_share * spread^2.
    outlying : share of honest readings that are off for a reason of their own.  range_db : over which they then are.
    heard_anyway : of how many survey scans' weight it counts that the survey may have missed an access point, then
    heard at faint_dbm +- faint_sigma_db.  unseen_scans : beside how many scans.
    heard_elsewhere : probability that an access point which may be anywhere is heard here.
    hearing_dbm, hearing_sigma_db : where access points begin to be missed at random.
    surest : most that the hearing of an access point is counted on.
    certain : probability of being heard from which one that is missing counts as one that was to be judged.
    most_evidence : of one scan, for or against.
    position_wrong : share of suspicious access points from which it is the position that is wrong, not they.
    suspicious : evidence from which an access point is; as much for it confirms it.
    """

    least_scans: float = 3.0
    expected_share: float = 0.3
    least_expected: int = 5
    noise_db: float = 4.0
    spread_share: float = 0.7
    outlying: float = 0.005
    range_db: float = 60.0
    heard_anyway: float = 0.05
    faint_dbm: float = -86.0
    faint_sigma_db: float = 8.0
    unseen_scans: float = 0.5
    heard_elsewhere: float = 0.1
    hearing_dbm: float = -88.0
    hearing_sigma_db: float = 6.0
    surest: float = 0.9
    certain: float = 0.7
    most_evidence: float = 3.0
    position_wrong: float = 0.25
    suspicious: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class ScanBesideMap:
    """Readings of one scan and what the map expects around, of n access points that it knows.

    bssid : (n,) ascending.  rssi_dbm : (n,) readings, NaN where there is no new one.  held : (n,) in the scan, be it
    with an old reading.  scans, heard, mean_dbm, spread_db : what is expected (app/wifi/expected_readings.py).
    """

    bssid: IntArray
    rssi_dbm: FloatArray
    held: BoolArray
    scans: float
    heard: FloatArray
    mean_dbm: FloatArray
    spread_db: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class ScanEvidence:
    """What one scan says about n access points.

    bssid : (n,) ascending.  evidence : (n,) positive against the access point, 0 where nothing is said.
    level_db : (n,) readings less what the scan has in common, NaN without.  expected_db : (n,) in the same terms, NaN
    of one that is not heard around.  judged : (n,) whether it had to show itself, or did.
    confirmed : (n,) whether it was heard as it was surveyed.
    suspicious : share of the judged with much against them.
    """

    bssid: IntArray
    evidence: FloatArray
    level_db: FloatArray
    expected_db: FloatArray
    judged: BoolArray
    confirmed: BoolArray
    suspicious: float


def scan_evidence(scan: ScanBesideMap, settings: FaultEvidenceSettings) -> ScanEvidence | None:
    """Weigh a scan, or None where too little is surveyed or heard."""
    if scan.scans < settings.least_scans:
        return None
    read, share = np.isfinite(scan.rssi_dbm), scan.heard / scan.scans
    expected = share > settings.expected_share
    both = read & expected
    if np.count_nonzero(both) < settings.least_expected:
        return None
    sigma_db = np.sqrt(settings.noise_db**2 + settings.spread_share * scan.spread_db**2)
    offset_db = float(np.median((scan.rssi_dbm - scan.mean_dbm)[both]))
    level_db = scan.rssi_dbm - offset_db
    # a place some metres off makes every access point differ more than by itself, and none of them suspicious
    typical = float(np.median(np.abs((level_db - scan.mean_dbm)[both] / sigma_db[both]))) / 0.6745
    sigma_db = sigma_db * max(1.0, typical)

    known = scan.scans + settings.unseen_scans
    at, silent = np.flatnonzero(read), np.flatnonzero(~scan.held)
    as_surveyed = scan.heard[at] * (
        (1.0 - settings.outlying) * _normal(level_db[at], scan.mean_dbm[at], sigma_db[at])
        + settings.outlying / settings.range_db
    )
    missed_by_survey = settings.heard_anyway * _normal(level_db[at], settings.faint_dbm, settings.faint_sigma_db)
    anywhere = settings.heard_elsewhere / settings.range_db
    evidence, judged = np.zeros(len(read)), read.copy()
    evidence[at] = np.log(anywhere * known / (as_surveyed + missed_by_survey))

    # a phone that hears less than the survey's did hears less of all
    keenness = min(1.0, float(np.count_nonzero(scan.held & expected)) / float(share[expected].sum()))
    audible = ndtr((scan.mean_dbm[silent] + offset_db - settings.hearing_dbm) / settings.hearing_sigma_db)
    hearing = np.minimum((scan.heard[silent] + settings.heard_anyway) / known * keenness * audible, settings.surest)
    evidence[silent] = np.log((1.0 - settings.heard_elsewhere) / (1.0 - hearing))
    judged[silent] = hearing > settings.certain
    suspicious = np.count_nonzero(judged & (evidence > settings.suspicious)) / np.count_nonzero(judged)
    return ScanEvidence(
        bssid=scan.bssid,
        evidence=np.clip(evidence, -settings.most_evidence, settings.most_evidence),
        level_db=level_db,
        expected_db=np.where(scan.heard > 0.0, scan.mean_dbm, np.nan),
        judged=judged,
        confirmed=read & (evidence < -settings.suspicious),
        suspicious=suspicious,
    )


def _normal(value: FloatArray, mean: FloatArray | float, sigma: FloatArray | float) -> FloatArray:
    return np.asarray(np.exp(-0.5 * ((value - mean) / sigma) ** 2) / (sigma * math.sqrt(2.0 * math.pi)), np.float64)
