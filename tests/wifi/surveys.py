"""Made-up surveys: a corridor that sounds different along its length, and arbitrary ones."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from app.observations import WifiScan
from app.wifi.fingerprint import Fingerprint

ACCESS_POINTS = 12


@st.composite
def fingerprints(draw: st.DrawFn, least: int = 1, most: int = 12) -> list[Fingerprint]:
    """Few places, floors and access points, so that they coincide."""
    place = st.tuples(st.sampled_from(["B2", "F1", "F2"]), *[st.sampled_from([0.0, 0.7, 1.5, 1.6, 9.9])] * 2)
    level = st.integers(-100, -20)
    readings = st.dictionaries(st.integers(1, ACCESS_POINTS), level, min_size=1)
    made = draw(st.lists(st.tuples(place, readings), min_size=least, max_size=most))
    return [
        fingerprint(floor, x_m, y_m, heard, time_s=float(number))
        for number, ((floor, x_m, y_m), heard) in enumerate(made)
    ]


def fingerprint(floor: str, x_m: float, y_m: float, heard: dict[int, int], time_s: float = 0.0) -> Fingerprint:
    """One of integer readings by access point."""
    bssid = np.array(list(heard), dtype=np.int64)
    return Fingerprint(floor, x_m, y_m, time_s, "walk", bssid, np.array(list(heard.values()), dtype=np.float64))


def corridor(seed: int = 0, floors: tuple[str, ...] = ("B1", "F1"), repeats: int = 3) -> list[Fingerprint]:
    """Scans every 2 m along 40 m on each floor; each floor has access points of its own every 8 m."""
    rng = np.random.default_rng(seed)
    survey = []
    for number, floor in enumerate(floors):
        for x_m in np.arange(0.0, 41.0, 2.0):
            for repeat in range(repeats):
                scan = heard_at(float(x_m), number, rng)
                survey.append(Fingerprint(floor, float(x_m), 1.0, float(repeat), "walk", scan.bssid, scan.rssi_dbm))
    return survey


def heard_at(x_m: float, floor: int, rng: np.random.Generator, noise_db: float = 2.0) -> WifiScan:
    """A scan in the corridor; floors are 15 dB apart and what is below -95 dBm is not heard."""
    at_m = np.tile(np.arange(0.0, 41.0, 8.0), 2)
    own = np.repeat([floor, 1 - floor], len(at_m) // 2) == floor
    rssi_dbm = -40.0 - 30.0 * np.log10(1.0 + np.abs(at_m - x_m)) - np.where(own, 0.0, 15.0)
    rssi_dbm = np.rint(rssi_dbm + noise_db * rng.standard_normal(len(at_m)))
    number = np.repeat([floor, 1 - floor], len(at_m) // 2) * 100 + np.tile(np.arange(len(at_m) // 2), 2)
    heard = rssi_dbm >= -95.0
    return WifiScan(100.0, number[heard].astype(np.int64), rssi_dbm[heard], np.full(int(heard.sum()), 99.0))
