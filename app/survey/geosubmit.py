"""Reports of the geosubmit v2 API: scans that survey apps place by latitude and longitude.

Each report is matched to the floor whose georeferenced frame contains it. The format has no floor; where frames lie
above one another the ground floor counts (level 0, else the nearest to it), unless the report's position has a member
`floor` that names another of them, which the format's other readers ignore. Where frames of several venues contain it,
or where it names a floor that is none of them, it has no place.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import orjson

from app.errors import InvalidInput
from app.floorplan.georeference import Georeference
from app.survey.admission import FloorExtent, PlaceReadings, checked_place, checked_time_ms
from app.wifi.fingerprint import Fingerprint
from app.wifi.readings import FRESH_S

COARSEST_M = 25.0
"""Reports whose position is less accurate say nothing about a place indoors."""
FEWEST = 2
"""Access points of a report, as the format asks for."""


@dataclass(frozen=True, slots=True)
class PlacedFloor:
    """A floor with a georeference. level : storeys above ground."""

    venue: str
    level: int
    extent: FloorExtent
    georeference: Georeference


def reports_of(sent: bytes) -> list[Any]:
    """The members of `items` of a body, unchecked.

    Raises
    ------
    InvalidInput : not JSON, or not such a body.
    """
    try:
        body = orjson.loads(sent)
    except orjson.JSONDecodeError as error:
        raise InvalidInput(f"the body is not JSON: {error}") from error
    if not isinstance(body, dict) or not isinstance(body.get("items"), list):
        raise InvalidInput("a list of reports is expected", "items")
    return list(body["items"])


def placed_reports(
    reports: Iterable[Any], floors: Sequence[PlacedFloor], received_ms: float
) -> Iterator[tuple[str, Fingerprint]]:
    """Venue and fingerprint of every report that can be used; the others are left out, as the format's service does.

    Parameters
    ----------
    reports : as of reports_of.  received_ms : when they came, for those without a time of their own.
    """
    for report in reports:
        try:
            yield _placed(report, floors, received_ms)
        except ValueError:  # one bad report must not keep the others out, and the format has no place to say so
            continue


def _placed(report: Any, floors: Sequence[PlacedFloor], received_ms: float) -> tuple[str, Fingerprint]:
    position, points = _member(report, "position", dict), _member(report, "wifiAccessPoints", list)
    if _number(position, "accuracy", 0.0) > COARSEST_M or _number(position, "age", 0.0) > 1000.0 * FRESH_S:
        raise ValueError("the position is too coarse or too old")
    floor, x_m, y_m = _floor_of(position, floors)
    time_ms = checked_time_ms(_number(report, "timestamp", received_ms))
    readings = PlaceReadings(floor.extent, x_m, y_m, time_ms / 1000.0)
    for point in points:
        try:
            _hear(readings, point)
        except ValueError:  # as above
            continue
    if len(readings.rssi_by_bssid) < FEWEST:
        raise ValueError(f"fewer than {FEWEST} access points that can be used")
    return floor.venue, readings.fingerprint()


def _floor_of(position: dict[str, Any], floors: Sequence[PlacedFloor]) -> tuple[PlacedFloor, float, float]:
    latitude_deg, longitude_deg = _number(position, "latitude"), _number(position, "longitude")
    if not (-90.0 <= latitude_deg <= 90.0 and -180.0 <= longitude_deg <= 180.0):
        raise ValueError("latitude and longitude are degrees")
    inside = []
    for floor in floors:
        place = floor.georeference.to_local(latitude_deg, longitude_deg)
        try:
            inside.append((floor, *checked_place(*place, floor.extent)))
        except ValueError:  # not this one
            continue
    said = position.get("floor")
    named = [one for one in inside if one[0].extent.floor == said] if said else inside
    nearest = sorted(named, key=lambda one: (abs(one[0].level), -one[0].level))
    if not nearest or len({one[0].venue for one in inside}) > 1:
        raise ValueError("no floor, or floors of several venues, hold the position")
    return nearest[0]


def _hear(readings: PlaceReadings, point: Any) -> None:
    if not isinstance(point, dict) or not isinstance(point.get("macAddress"), str):
        raise ValueError("no macAddress")
    if _number(point, "age", 0.0) > 1000.0 * FRESH_S:
        raise ValueError("heard elsewhere")
    ssid = point.get("ssid")
    readings.hear(point["macAddress"], _number(point, "signalStrength"), ssid if isinstance(ssid, str) else "")


def _member(report: Any, name: str, kind: type[Any]) -> Any:
    value = report.get(name) if isinstance(report, dict) else None
    if not isinstance(value, kind):
        raise ValueError(f"{name} is missing")
    return value


def _number(holder: dict[str, Any], name: str, missing: float | None = None) -> float:
    value = holder.get(name, missing)
    value = missing if value is None else value
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{name} must be a number")
    return float(value)
