"""One scan to one fix with its own covariance, by the matcher that a method asks for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from app.observations import RadioFix, WifiScan
from app.wifi.match import Match
from app.wifi.radio_map import RadioMap
from app.wifi.readings import fresh_readings
from app.wifi.soft_match import soft_match
from app.wifi.weibull_bayes import weibull_bayes
from app.wifi.wknn import wknn

LASTING = 0.6
"""Share of a fix's variance that stays the same for as long as the surroundings do, where a method does not say."""
HEAVY_TAILS = 1.6
"""By what a variance that is the same for every scan is multiplied in evidence: errors of such fixes are seldom large,
but then for long. With it levels of smoothed tracks hold what those at the time did, on folds 1-4."""


@dataclass(frozen=True, slots=True)
class FixError:
    """Variance of a WiFi fix in each direction: least_m2 + scatter * that of its neighbours + distance_m2 * d^2.

    d is the signal distance to the best neighbour, in the matcher's unit: a scan unlike anything surveyed was taken
    elsewhere. lasting : share of the variance that stays the same for as long as the surroundings do.
    Least squares over the scans of folds 1-4 of the mall walks, lasting from their correlation in time.
    """

    least_m2: float = 8.0
    scatter: float = 0.7
    distance_m2: float = 300.0
    lasting: float = 0.8

    def variance_m2(self, match: Match) -> float:
        """Of the fix of a match."""
        scatter_m2 = float(np.trace(match.covariance_m2)) / 2.0
        return self.least_m2 + self.scatter * scatter_m2 + self.distance_m2 * match.signal_distance**2


class Matcher(StrEnum):
    """How scans are compared with the radio map."""

    WEIBULL_BAYES = "weibull_bayes"
    WKNN = "wknn"
    SOFT = "soft"


_MATCHERS: dict[Matcher, Callable[..., Match | None]] = {
    Matcher.WEIBULL_BAYES: weibull_bayes,
    Matcher.WKNN: wknn,
    Matcher.SOFT: soft_match,
}


def match_scan(
    radio_map: RadioMap | None, scan: WifiScan, matcher: Matcher, least_known: int, floor: str | None = None
) -> Match | None:
    """Place of a scan's fresh readings.

    Parameters
    ----------
    least_known : access points known to the map with which a scan is usable.
    floor : name of the floor to place it on; None: the one that it sounds most like.

    Returns
    -------
    None where there is no map, or the scan says too little.
    """
    if radio_map is None:
        return None
    fresh = fresh_readings(scan)
    where = radio_map.floors.index(floor) if floor in radio_map.floors else None
    match = _MATCHERS[matcher](radio_map, fresh.bssid, fresh.rssi_dbm, floor=where)
    return None if match is None or match.known < least_known else match


def said(
    scan: WifiScan, floor: str, match: Match, variance_m2: float, fits: bool, lasting: float = LASTING
) -> RadioFix:
    """A scan's fix as evidence.

    Parameters
    ----------
    variance_m2 : of its error in each direction.  fits : whether the method's track bears it out.
    lasting : share of the variance.
    """
    noise_m2 = (1.0 - lasting) * variance_m2 * np.eye(2)
    return RadioFix(scan.time_s, floor, match.xy_m, noise_m2, lasting * variance_m2, match.signal_distance, fits)
