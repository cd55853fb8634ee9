"""A fingerprint: the readings heard at one surveyed place."""

from __future__ import annotations

from dataclasses import dataclass

from app.estimation.arrays import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Fingerprint:
    """Readings heard at one place and time of a survey.

    x_m, y_m : in the floor's frame.  walk : identifier of the survey walk (or survey) it came from: what is left out
    together in cross-validation.  bssid : (n,) keys of what was heard, each once: 48-bit MAC addresses as integers, and
    keys of Bluetooth beacons (app/wifi/beacons.py).  rssi_dbm : (n,).
    """

    floor: str
    x_m: float
    y_m: float
    time_s: float
    walk: str
    bssid: IntArray
    rssi_dbm: FloatArray
