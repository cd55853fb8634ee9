"""Access points of a scan that are not to be relied on: those on the venue's watch list, and those that this session
found to be other than surveyed."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.arrays import FloatArray, IntArray, looked_up, within
from app.fusion.interface import Site
from app.fusion.state_codec import storable
from app.integrity.access_point_faults import FaultEvidenceSettings, ScanBesideMap, scan_evidence
from app.integrity.access_point_record import (
    AccessPointFault,
    AccessPointRecord,
    RecordSettings,
    kinds_of,
    nothing_recorded,
    recorded,
)
from app.observations import Excluded, WifiScan
from app.wifi.bssid import format_bssid
from app.wifi.expected_readings import expected_readings
from app.wifi.radio_map import RadioMap
from app.wifi.readings import only

storable(AccessPointRecord)


@dataclass(frozen=True, slots=True)
class AccessPointWatchSettings:
    """evidence, record : what one scan says, and what is made of several.
    least_sigma_m, most_sigma_m : how far around the position the map is asked, by the position's own uncertainty.
    new_within_s : a reading older than this, or one that an earlier scan could have had, is no news.
    most_left_out : share of a scan's known access points that may be left out at most, the worst first: no few should
    make the many look wrong."""

    evidence: FaultEvidenceSettings = field(default_factory=FaultEvidenceSettings)
    record: RecordSettings = field(default_factory=RecordSettings)
    least_sigma_m: float = 5.0
    most_sigma_m: float = 8.0
    new_within_s: float = 4.0
    most_left_out: float = 1.0 / 3.0


@storable
@dataclass(frozen=True, slots=True, eq=False)
class AccessPointWatch:
    """Of a session. record : what speaks against which access points.  listed : (k,) those of the newest scan that are
    on the venue's watch list.  floor : of the map, that the record is of.  scan_s : when the newest scan on it came.
    """

    record: AccessPointRecord = field(default_factory=nothing_recorded)
    listed: IntArray = field(default_factory=lambda: np.empty(0, np.int64))
    floor: int = -1
    scan_s: float = -math.inf


def trusted(
    watch: AccessPointWatch, scan: WifiScan, site: Site, settings: AccessPointWatchSettings
) -> tuple[AccessPointWatch, WifiScan]:
    """The scan without what is not to be relied on, and the watch that knows what of it is listed."""
    listed = np.empty(0, np.int64)
    if site.watched:
        listed = scan.bssid[np.array([bssid in site.watched for bssid in scan.bssid.tolist()], dtype=np.bool_)]
    out = np.concatenate([listed, _left_out(watch.record, scan, site.radio_map, settings)])
    if len(listed) or len(watch.listed):
        watch = replace(watch, listed=listed)
    if not len(out):
        return watch, scan
    return watch, only(scan, ~within(scan.bssid, np.sort(out)))


def _left_out(
    record: AccessPointRecord, scan: WifiScan, radio_map: RadioMap | None, settings: AccessPointWatchSettings
) -> IntArray:
    if radio_map is None or not record.excluded.any():
        return np.empty(0, np.int64)
    rows = np.flatnonzero(record.excluded & within(record.bssid, np.sort(scan.bssid)))
    most = int(settings.most_left_out * np.count_nonzero(within(scan.bssid, radio_map.bssid)))
    return record.bssid[rows[np.argsort(-record.score[rows], kind="stable")[:most]]]


def not_relied_on(watch: AccessPointWatch, site: Site) -> IntArray:
    """(n,) access points that the map is to be read without: what trusted leaves out of scans, heard or not."""
    found = watch.record.bssid[watch.record.excluded]
    return np.union1d(found, np.fromiter(site.watched, np.int64, len(site.watched))) if site.watched else found


def watched(
    watch: AccessPointWatch,
    scan: WifiScan,
    site: Site,
    floor: int,
    place: tuple[FloatArray, FloatArray],
    settings: AccessPointWatchSettings,
) -> tuple[AccessPointWatch, IntArray]:
    """The watch after a scan that the track bears out, and the access points that it heard as they were surveyed.

    Parameters
    ----------
    scan : as it came.  floor : index into the map's floors.  place : (2,) and (2, 2) where it was taken, how surely.
    """
    radio_map = site.radio_map
    nothing = np.empty(0, np.int64)
    if radio_map is None or not len(radio_map.bssid):
        return watch, nothing
    xy_m, covariance_m2 = place
    variance_m2 = min(float(np.trace(covariance_m2)) / 2.0, settings.most_sigma_m**2 - settings.least_sigma_m**2)
    around = expected_readings(radio_map, floor, xy_m, math.sqrt(settings.least_sigma_m**2 + variance_m2))
    known = radio_map.bssid
    held, rssi_dbm = np.zeros(len(known), np.bool_), np.full(len(known), np.nan)
    at, in_map = looked_up(scan.bssid, known)
    held[at[in_map]] = True
    new = in_map & (scan.seen_s > max(watch.scan_s, scan.time_s - settings.new_within_s))
    rssi_dbm[at[new]] = scan.rssi_dbm[new]
    record = watch.record if watch.floor == floor else nothing_recorded()
    judged = held | (around.heard > settings.evidence.expected_share * around.scans)
    recorded_at, recorded_in_map = looked_up(record.bssid, known)
    judged[recorded_at[recorded_in_map]] = True
    if site.watched:
        judged &= ~within(known, np.sort(np.fromiter(site.watched, np.int64, len(site.watched))))
    beside = ScanBesideMap(
        bssid=known[judged],
        rssi_dbm=rssi_dbm[judged],
        held=held[judged],
        scans=around.scans,
        heard=around.heard[judged],
        mean_dbm=around.mean_dbm[judged],
        spread_db=around.spread_db[judged],
    )
    evidence = scan_evidence(beside, settings.evidence)
    confirmed = nothing
    if evidence is not None and evidence.suspicious <= settings.evidence.position_wrong:
        record = recorded(record, evidence, beside.rssi_dbm, xy_m, settings.record)
        confirmed = evidence.bssid[evidence.confirmed]
    return replace(watch, record=record, floor=floor, scan_s=scan.time_s), confirmed


def excluded(watch: AccessPointWatch, settings: AccessPointWatchSettings) -> tuple[Excluded, ...]:
    """What is left out, and why."""
    listed = [Excluded("watched: on the watch list of the radio map", bssid=int(one)) for one in watch.listed]
    record = watch.record
    if not record.excluded.any():
        return tuple(listed)
    kinds = kinds_of(record, settings.record)
    told = set(watch.listed.tolist())
    return (
        *listed,
        *(
            # watch lists know the fault by the first word
            Excluded(f"{kinds[row]}: {_signs(record, row, kinds[row])}", bssid=bssid)
            for row in np.flatnonzero(record.excluded).tolist()
            if (bssid := int(record.bssid[row])) not in told
        ),
    )


def _signs(record: AccessPointRecord, row: int, kind: AccessPointFault) -> str:
    level, misfits = f"{record.level_dbm[row]:.0f} dBm", _scans(int(record.misfits[row]))
    match kind:
        case AccessPointFault.VANISHED:
            return f"missing from {_scans(int(record.misses[row]))} where the survey heard it"
        case AccessPointFault.SPOOFED:
            return f"{level} over {record.reach_m[row]:.0f} m of the way"
        case AccessPointFault.SWAPPED:
            return f"sounds like {format_bssid(int(record.partner[row]))}, which sounds like it"
        case AccessPointFault.DUPLICATED:
            return f"heard in {misfits} as it cannot be, beside where it was surveyed"
        case AccessPointFault.MOVED:
            return f"heard in {misfits} as it cannot be where it was surveyed, {level} on average"


def _scans(count: int) -> str:
    return "1 scan" if count == 1 else f"{count} scans"
