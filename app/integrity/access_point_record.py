"""Which access points the scans of a session have spoken against, how they went wrong, and which are left out for it.

A cumulative sum (CUSUM) of the evidence of each: it never falls below 0, so that a long good record does not hide a
change, and never rises so high that an access point which is as surveyed again is not soon used again. Those with
nothing against them are not on record.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.estimation.arrays import BoolArray, FloatArray, IntArray, looked_up, within
from app.integrity.access_point_faults import ScanEvidence


class AccessPointFault(StrEnum):
    """How an access point went wrong."""

    MOVED = "moved"
    SWAPPED = "swapped"
    SPOOFED = "spoofed"
    DUPLICATED = "duplicated"
    VANISHED = "vanished"


@dataclass(frozen=True, slots=True)
class RecordSettings:
    """Measured on folds 1-4 of the mall walks.

    excluded_at : score from which an access point is left out; it takes four scans.  readmitted_at : down to which it
    stays so.  most_score : where the score stops.
    kept_at : score below which nothing is on record.  most : access points on record, those with the highest scores.
    suspicious : evidence of one scan that counts when the kind of fault is told.
    off_db : difference from what is expected from which levels are those of another.
    steady_db, spoofed_reach_m, spoofed_readings : one that is equally loud, to this standard deviation, at so many
    places this far apart is imitated.
    partner_db : sum of the differences with which two each sound as the other should.  partner_votes : scans.
    """

    excluded_at: float = 12.0
    readmitted_at: float = 4.0
    most_score: float = 18.0
    kept_at: float = 1.0
    most: int = 128
    suspicious: float = 1.0
    off_db: float = 10.0
    steady_db: float = 2.5
    spoofed_reach_m: float = 8.0
    spoofed_readings: int = 4
    partner_db: float = 12.0
    partner_votes: int = 2


@dataclass(frozen=True, slots=True, eq=False)
class AccessPointRecord:
    """The n access points that something speaks against.

    bssid : (n,) ascending.  score : (n,) cumulative evidence.  excluded : (n,) whether it is left out.
    misfits, misses, fits : (n,) scans that heard it as it cannot be, that did not hear it where it is certain, and that
    heard it where it is expected and not too faint.
    readings : (n,) how many.  level_dbm, level_square_db2 : (n,) their mean, and sum of squares about it.
    begun_xy_m : (n, 2) where the phone was at the first of them.  reach_m : (n,) how far from there it has been.
    partner : (n,) which access point it may have been swapped with, 0 for none.  votes : (n,) for that.
    """

    bssid: IntArray
    score: FloatArray
    excluded: BoolArray
    misfits: IntArray
    misses: IntArray
    fits: IntArray
    readings: IntArray
    level_dbm: FloatArray
    level_square_db2: FloatArray
    begun_xy_m: FloatArray
    reach_m: FloatArray
    partner: IntArray
    votes: IntArray


def nothing_recorded() -> AccessPointRecord:
    """The record of a session against which no scan has spoken."""
    counts, levels = np.empty(0, np.int64), np.empty(0)
    return AccessPointRecord(
        bssid=counts,
        score=levels,
        excluded=np.empty(0, np.bool_),
        misfits=counts,
        misses=counts,
        fits=counts,
        readings=counts,
        level_dbm=levels,
        level_square_db2=levels,
        begun_xy_m=np.empty((0, 2)),
        reach_m=levels,
        partner=counts,
        votes=counts,
    )


def recorded(
    record: AccessPointRecord, scan: ScanEvidence, rssi_dbm: FloatArray, xy_m: FloatArray, settings: RecordSettings
) -> AccessPointRecord:
    """The record after one more scan.

    Parameters
    ----------
    scan : of every access point on record too; one that it lacks is forgotten.
    rssi_dbm : (n,) its readings, NaN without.  xy_m : (2,) where it was taken.
    """
    at, old = looked_up(record.bssid, scan.bssid)
    held = at[old]
    score = np.zeros(len(scan.bssid))
    score[held] = record.score[old]
    score = np.clip(score + scan.evidence, 0.0, settings.most_score)
    rows = np.flatnonzero(score >= settings.kept_at)
    if len(rows) > settings.most:
        rows = np.sort(rows[np.argpartition(-score[rows], settings.most)[: settings.most]])

    def before(column: NDArray[Any]) -> NDArray[Any]:
        spread = np.zeros((len(scan.bssid), *column.shape[1:]), column.dtype)
        spread[held] = column[old]
        return spread[rows]

    score, level = score[rows], rssi_dbm[rows]
    read, against = np.isfinite(level), scan.evidence[rows] > settings.suspicious
    readings = before(record.readings)
    begun_xy_m = np.where((readings == 0)[:, np.newaxis], xy_m, before(record.begun_xy_m))
    apart_m = np.hypot(*(begun_xy_m - xy_m).T)
    mean, square = before(record.level_dbm), before(record.level_square_db2)
    readings = readings + read
    change = np.where(read, level - mean, 0.0)
    mean_now = mean + change / np.maximum(readings, 1)
    as_loud = scan.judged[rows] & (scan.level_db[rows] > scan.expected_db[rows] - settings.off_db)
    now = AccessPointRecord(
        bssid=scan.bssid[rows],
        score=score,
        excluded=score >= np.where(before(record.excluded), settings.readmitted_at, settings.excluded_at),
        misfits=before(record.misfits) + (read & against),
        misses=before(record.misses) + (~read & against),
        fits=before(record.fits) + as_loud,
        readings=readings,
        level_dbm=mean_now,
        level_square_db2=square + change * np.where(read, level - mean_now, 0.0),
        begun_xy_m=begun_xy_m,
        reach_m=np.where(read, np.maximum(before(record.reach_m), apart_m), before(record.reach_m)),
        partner=before(record.partner),
        votes=before(record.votes),
    )
    return _voted(now, scan.level_db[rows], scan.expected_db[rows], settings)


def kinds_of(record: AccessPointRecord, settings: RecordSettings) -> list[AccessPointFault]:
    """How each access point on record has gone wrong, as far as a session can tell.

    One that was carried to where nobody surveyed it, and of which nothing tells how it is at home, is `moved`.
    """
    silent = record.misses > record.misfits
    steady_db = np.sqrt(record.level_square_db2 / np.maximum(record.readings - 1, 1))
    spoofed = (
        (steady_db < settings.steady_db)
        & (record.readings >= settings.spoofed_readings)
        & (record.reach_m > settings.spoofed_reach_m)
    )
    mutual = within(record.partner, record.bssid[record.excluded])
    swapped = (record.votes >= settings.partner_votes) & mutual
    duplicated = (record.misses == 0) & (record.fits >= settings.partner_votes)
    kinds = np.select(
        [silent, spoofed, swapped, duplicated],
        [AccessPointFault.VANISHED, AccessPointFault.SPOOFED, AccessPointFault.SWAPPED, AccessPointFault.DUPLICATED],
        AccessPointFault.MOVED,
    )
    return [AccessPointFault(kind) for kind in kinds.tolist()]


def _voted(
    record: AccessPointRecord, level_db: FloatArray, expected_db: FloatArray, settings: RecordSettings
) -> AccessPointRecord:
    """Majority vote over scans (Boyer and Moore) on the access point that each sounds like, and that sounds like it."""
    with np.errstate(invalid="ignore"):
        rows = np.flatnonzero(record.excluded & (np.abs(level_db - expected_db) > settings.off_db))
    if len(rows) < 2:
        return record
    like_db = np.abs(level_db[rows, np.newaxis] - expected_db[rows])
    apart_db = like_db + like_db.T
    np.fill_diagonal(apart_db, np.inf)
    best = apart_db.argmin(axis=1)
    found = apart_db[np.arange(len(rows)), best] < settings.partner_db
    rows, heard_like = rows[found], record.bssid[rows[best[found]]]
    partner, votes = record.partner.copy(), record.votes.copy()
    again, none = partner[rows] == heard_like, votes[rows] == 0
    partner[rows] = np.where(none, heard_like, partner[rows])
    votes[rows] += np.where(again | none, 1, -1)
    return replace(record, partner=partner, votes=votes)
