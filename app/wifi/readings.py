"""Which readings of a scan a matcher should see."""

from __future__ import annotations

import numpy as np

from app.estimation.arrays import BoolArray, IntArray
from app.observations import WifiScan

FRESH_S = 6.0
"""On the move what was heard longer ago belongs to another place; the map is made the same way (decision 0002)."""


def fresh_readings(scan: WifiScan, max_age_s: float = FRESH_S) -> WifiScan:
    """The scan without what its phone only repeats: readings `seen` more than max_age_s before it came."""
    return only(scan, np.flatnonzero(scan.seen_s >= scan.time_s - max_age_s))


def strongest(scan: WifiScan, count: int) -> WifiScan:
    """The scan's strongest readings, strongest first; of equal ones the lower address."""
    return only(scan, np.lexsort((scan.bssid, -scan.rssi_dbm))[:count])


def at_least(scan: WifiScan, threshold_dbm: float) -> WifiScan:
    """The scan's readings of a strength: weak ones are lost at random while the phone moves."""
    return only(scan, np.flatnonzero(scan.rssi_dbm >= threshold_dbm))


def only(scan: WifiScan, kept: IntArray | BoolArray) -> WifiScan:
    """The scan with these of its readings."""
    return WifiScan(scan.time_s, scan.bssid[kept], scan.rssi_dbm[kept], scan.seen_s[kept])


def is_news(scan: WifiScan, earlier_s: float | None) -> bool:
    """Whether at least half of a scan's fresh readings were heard after an earlier scan; phones repeat themselves."""
    seen_s = fresh_readings(scan).seen_s
    return earlier_s is None or 2 * int(np.count_nonzero(seen_s > earlier_s)) >= len(seen_s)
