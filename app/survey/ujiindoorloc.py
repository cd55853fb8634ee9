"""Surveys in the layout of UJIIndoorLoc: one scan a row, one column an access point, 100 for not heard.

Its places are Web Mercator metres, which are longer than metres on the ground by 1 / cos(latitude), and its access
points are numbered columns without addresses; they get locally administered ones, 02:00:00:00:00:01 for WAP001.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import IO

from app.errors import InvalidInput
from app.floorplan.georeference import Georeference
from app.survey.rejection import Rejections
from app.wifi.bssid import format_bssid

NOT_HEARD = 100.0
EARTH_RADIUS_M = 6378137.0
"""Of the sphere of EPSG:3857."""
FIRST_ADDRESS = 0x020000000000
COLUMNS = ("LONGITUDE", "LATITUDE", "FLOOR", "BUILDINGID", "TIMESTAMP")


@dataclass(frozen=True, slots=True)
class UjiScan:
    """One row. place_deg : latitude and longitude.  readings : number of the access point's column, and dBm."""

    row: int
    floor: str
    level: int
    place_deg: tuple[float, float]
    time_ms: int
    readings: tuple[tuple[int, float], ...]


def is_ujiindoorloc(header: bytes) -> bool:
    """Whether a file that begins like this is in the layout."""
    return header.lstrip(b'\xef\xbb\xbf"').upper().startswith(b"WAP001")


def read_ujiindoorloc(text: IO[str], rejections: Rejections) -> Iterator[UjiScan]:
    """Scans of a file; rows that cannot be used are rejected by their number, the header being row 1.

    Raises
    ------
    InvalidInput : a column is missing.
    """
    rows = csv.reader(text)
    header = [name.strip().upper() for name in next(rows, [])]
    at = {name: header.index(name) for name in COLUMNS if name in header}
    if len(at) < len(COLUMNS):
        missing = ", ".join(name for name in COLUMNS if name not in at)
        raise InvalidInput(f"columns {missing} are missing", missing)
    points = [
        (column, int(name[3:])) for column, name in enumerate(header) if name[:3] == "WAP" and name[3:].isdecimal()
    ]
    for row, cells in enumerate(rows, start=2):
        try:
            if len(cells) != len(header):
                raise ValueError(f"{len(cells)} cells where the header has {len(header)}")
            yield _scan(row, cells, at, points)
        except (ValueError, OverflowError) as error:
            rejections.add(row, str(error))


def uji_address(number: int) -> str:
    """The address that stands for a column."""
    return format_bssid(FIRST_ADDRESS + number)


def mercator_to_wgs84(easting_m: float, northing_m: float) -> tuple[float, float]:
    """Latitude and longitude in degrees of an EPSG:3857 place."""
    latitude = math.atan(math.sinh(northing_m / EARTH_RADIUS_M))
    return math.degrees(latitude), math.degrees(easting_m / EARTH_RADIUS_M)


def frame_about(places_deg: list[tuple[float, float]], margin_m: float) -> tuple[Georeference, float, float]:
    """A frame that holds some WGS 84 places with a margin: its origin, north up, and its width and height in metres."""
    south, west = (min(axis) for axis in zip(*places_deg, strict=True))
    corner = Georeference(south, west, 0.0)
    origin = Georeference(*corner.to_wgs84(-margin_m, -margin_m), 0.0)
    reach = [origin.to_local(*place) for place in places_deg]
    width_m, height_m = (max(axis) + margin_m for axis in zip(*reach, strict=True))
    return origin, width_m, height_m


def _scan(row: int, cells: list[str], at: dict[str, int], points: list[tuple[int, int]]) -> UjiScan:
    level, building = (int(float(cells[at[name]])) for name in ("FLOOR", "BUILDINGID"))
    easting_m, northing_m = float(cells[at["LONGITUDE"]]), float(cells[at["LATITUDE"]])
    if not (abs(easting_m) < 2.1e7 and abs(northing_m) < 2.1e7):
        raise ValueError("LONGITUDE and LATITUDE must be Web Mercator metres")
    heard = [(number, float(cells[column])) for column, number in points if cells[column] not in ("100", "")]
    return UjiScan(
        row=row,
        floor=f"B{building}F{level}",
        level=level,
        place_deg=mercator_to_wgs84(easting_m, northing_m),
        time_ms=round(1000.0 * float(cells[at["TIMESTAMP"]])),
        readings=tuple((number, rssi_dbm) for number, rssi_dbm in heard if rssi_dbm != NOT_HEARD),
    )
