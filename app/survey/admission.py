"""What every format of survey has to satisfy: places on the floor, readings that are measurements."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.errors import InvalidInput, NotFound
from app.survey.rejection import Rejections
from app.wifi.beacons import beacon_key
from app.wifi.bssid import parse_bssid
from app.wifi.fingerprint import Fingerprint

RSSI_RANGE_DBM = (-127.0, 20.0)
"""Readings outside are no measurement."""
LATEST_MS = 4_102_444_800_000
"""2100-01-01. What lies beyond is not in milliseconds: nanoseconds since a phone was switched on, after an hour."""
OPT_OUT = "_nomap"
"""End of an SSID whose owner does not want to be mapped; such readings are dropped unseen."""
LONGEST_BEACON_ID = 128
MARGIN_M = 10.0
"""Places may lie so far outside the floor's frame: plans are drawn tight and surveyors lean out."""
MAKE_FLOOR = "make it: PUT /v1/venues/{venue}/floors/{floor}, or import a folder of floors"
GROUPS = 50
MOST_READINGS = 10_000
"""Access points in one fingerprint; no place on Earth has more, and each must fit in memory."""


@dataclass(frozen=True, slots=True)
class FloorExtent:
    """The frame that places on a floor lie in; a size of None is not known and not checked."""

    floor: str
    width_m: float | None
    height_m: float | None


@dataclass(slots=True)
class SurveyNotes:
    """What reading a survey leaves beside its fingerprints; complete when the last one has been read.

    device : as the sender describes it, empty if not at all.
    """

    device: Mapping[str, Any] = field(default_factory=dict)
    rejections: Rejections = field(default_factory=Rejections)


def checked_rssi(rssi_dbm: float) -> float:
    """The same. Raises ValueError outside the range, and for NaN."""
    if not RSSI_RANGE_DBM[0] <= rssi_dbm <= RSSI_RANGE_DBM[1]:
        raise ValueError(f"rssi {rssi_dbm:g} is outside [-127, 20] dBm")
    return rssi_dbm


def checked_time_ms(time_ms: float) -> float:
    """The same. Raises ValueError for what cannot be Unix milliseconds."""
    if not 0 <= time_ms < LATEST_MS:
        raise ValueError("t must be Unix milliseconds")
    return time_ms


def checked_place(x_m: float, y_m: float, extent: FloorExtent) -> tuple[float, float]:
    """The same. Raises ValueError for a place that is not finite or not on the floor."""
    if not (math.isfinite(x_m) and math.isfinite(y_m)):
        raise ValueError("x and y must be finite")
    name, why = off_floor(x_m, y_m, extent)
    if name:
        raise ValueError(f"{name} {why}")
    return x_m, y_m


def off_floor(x_m: float, y_m: float, extent: FloorExtent) -> tuple[str, str]:
    """Which of x and y is not on the floor, and why; both empty of a place that is on it, or near."""
    for name, value, size in (("x", x_m, extent.width_m), ("y", y_m, extent.height_m)):
        if size is not None and not -MARGIN_M <= value <= size + MARGIN_M:
            return name, f"{value:g} is outside floor {extent.floor} (0 to {size:g} m)"
    return "", ""


def known_floor(floors: Mapping[str, FloorExtent], floor: str) -> FloorExtent:
    """The floor of that name. Raises ValueError if the venue has none."""
    extent = floors.get(floor)
    if extent is None:
        raise ValueError(f"the venue has no floor {floor[:64]!r}; {MAKE_FLOOR}")
    return extent


@dataclass(slots=True)
class PlaceReadings:
    """A fingerprint while its readings come in; of an access point or beacon heard twice the stronger counts."""

    extent: FloorExtent
    x_m: float
    y_m: float
    time_s: float
    rssi_by_bssid: dict[int, float] = field(default_factory=dict)

    def hear(self, bssid: str, rssi_dbm: float, ssid: str = "") -> None:
        """Add a reading. Raises ValueError for one that is no measurement."""
        rssi_dbm, address = checked_rssi(rssi_dbm), parse_bssid(bssid)
        if not ssid.endswith(OPT_OUT):
            if len(self.rssi_by_bssid) >= MOST_READINGS:
                raise ValueError(f"more than {MOST_READINGS} access points at one place and time")
            self.rssi_by_bssid[address] = max(rssi_dbm, self.rssi_by_bssid.get(address, rssi_dbm))

    def hear_beacon(self, beacon: str, rssi_dbm: float) -> None:
        """Add a reading of a Bluetooth beacon. Raises ValueError for one that is no measurement."""
        rssi_dbm = checked_rssi(rssi_dbm)
        if not 0 < len(beacon) <= LONGEST_BEACON_ID:
            raise ValueError(f"the id of a beacon has 1 to {LONGEST_BEACON_ID} characters")
        if len(self.rssi_by_bssid) >= MOST_READINGS:
            raise ValueError(f"more than {MOST_READINGS} access points at one place and time")
        key = beacon_key(beacon)
        self.rssi_by_bssid[key] = max(rssi_dbm, self.rssi_by_bssid.get(key, rssi_dbm))

    def fingerprint(self) -> Fingerprint:
        """The finished fingerprint.

        Its `walk` is one of GROUPS, chosen by the place: a survey of points has no walks to leave out in
        cross-validation, and what was measured at one point must be left out together.
        """
        place = f"{self.extent.floor} {self.x_m:.1f} {self.y_m:.1f}"
        return Fingerprint(
            floor=self.extent.floor,
            x_m=self.x_m,
            y_m=self.y_m,
            time_s=self.time_s,
            walk=f"points-{zlib.crc32(place.encode()) % GROUPS}",
            bssid=np.fromiter(self.rssi_by_bssid, np.int64, len(self.rssi_by_bssid)),
            rssi_dbm=np.fromiter(self.rssi_by_bssid.values(), np.float64, len(self.rssi_by_bssid)),
        )


def named_floor(floors: Mapping[str, FloorExtent], floor: object) -> FloorExtent:
    """The floor that a request names.

    Raises
    ------
    InvalidInput : it names none.
    NotFound : the venue has no such floor. Both at field `floor`.
    """
    has = ", ".join(sorted(floors)) or f"none; {MAKE_FLOOR}"
    if not isinstance(floor, str):
        raise InvalidInput(f"floor must name a floor of the venue, which has {has}", "floor")
    if floor not in floors:
        raise NotFound(f"the venue has no floor {floor[:64]!r}; it has {has}", "floor")
    return floors[floor]
