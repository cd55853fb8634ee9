"""Logs of the GetSensorData app, as indoor positioning competitions publish them, turned into traces.

Lines are `TYPE;AppTimestamp;SensorTimestamp;values...`, times in seconds since the log began; `POSI;time;counter;
latitude;longitude;floor;building` says where the surveyor stood. A log may climb stairs: each stretch between waypoints
of one floor becomes a trace of its own.
"""

from __future__ import annotations

import re
from calendar import timegm
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import groupby
from time import strptime
from typing import IO

from app.floorplan.georeference import Georeference
from app.survey.rejection import Rejections

UNKNOWN_START_MS = 1_500_000_000_000
"""When a log began that does not say; only the order of its times matters."""
_WIFI = re.compile(
    rb"WIFI;([\d.]+);[^;]*;(.*);((?:[0-9A-Fa-f]{2}[:-]){5}[0-9A-Fa-f]{2})(?:;(\d+(?:\.\d+)?))?;(-?\d+(?:\.\d+)?);?\s*$"
)
_CREATED = re.compile(rb"[A-Z][a-z]{2} ([A-Z][a-z]{2}) +(\d{1,2}) (\d\d:\d\d:\d\d) .*?(\d{4})")
_SENSORS = {
    b"ACCE": b"TYPE_ACCELEROMETER",
    b"GYRO": b"TYPE_GYROSCOPE",
    b"MAGN": b"TYPE_MAGNETIC_FIELD",
}
_ROTATION = b"AHRS"  # after three angles, x, y, z of the unit quaternion
MARKS = (b"WIFI;", b"ACCE;", b"POSI;", b"MAGN;", b"GYRO;", b"AHRS;")


@dataclass(frozen=True, slots=True)
class Waypoint:
    """Where the surveyor stood. time_s : since the log began."""

    time_s: float
    latitude_deg: float
    longitude_deg: float
    floor: str
    level: int


@dataclass(frozen=True, slots=True)
class Stretch:
    """Waypoints of one floor that follow one another."""

    floor: str
    waypoints: tuple[Waypoint, ...]


def is_sensor_log(beginning: bytes) -> bool:
    """Whether a file that begins like this is such a log."""
    return b"GetSensorData" in beginning or any(line.startswith(MARKS) for line in beginning.splitlines())


def stretches_of(lines: Iterable[bytes], name: str, rejections: Rejections) -> list[Stretch]:
    """The stretches of a log; waypoints that say nothing are rejected by their line."""
    waypoints = []
    for number, line in enumerate(lines, start=1):
        if line.startswith(b"POSI;"):
            try:
                waypoints.append(_waypoint(line.rstrip().split(b";")))
            except (ValueError, IndexError, OverflowError) as error:
                reason = "too few cells" if isinstance(error, IndexError) else str(error)
                rejections.add(f"{name}:{number}", f"POSI: {reason}")
    waypoints.sort(key=lambda one: one.time_s)
    grouped = [Stretch(floor, tuple(group)) for floor, group in groupby(waypoints, key=lambda one: one.floor)]
    for stretch in grouped:
        if len(stretch.waypoints) < 2:
            at = f"{name} at {stretch.waypoints[0].time_s:g} s"
            rejections.add(at, f"a single POSI on {stretch.floor}: a stretch needs two to place its scans")
    found = [stretch for stretch in grouped if len(stretch.waypoints) >= 2]
    if not found:
        rejections.add(name, "no two POSI of one floor follow one another: its scans have no place")
    return found


def write_traces(
    lines: Iterable[bytes], stretches: list[Stretch], frames: Mapping[str, Georeference], out: list[IO[bytes]]
) -> None:
    """Write each stretch as a trace, waypoints in the frame of its floor.

    Parameters
    ----------
    frames : by floor.  out : one stream a stretch.
    """
    start_ms = UNKNOWN_START_MS
    for stream in out:
        stream.write(b"#\tconverted from a GetSensorData log\n")
    begun = False
    for line in lines:
        if line.startswith(b"%") and not begun:
            start_ms = _created_ms(line) or start_ms
            continue
        record = _record(line, start_ms)
        if record is None:
            continue
        begun = True
        time_s, text = record
        for stretch, stream in zip(stretches, out, strict=True):
            if stretch.waypoints[0].time_s <= time_s <= stretch.waypoints[-1].time_s:
                stream.write(text)
    for stretch, stream in zip(stretches, out, strict=True):
        for waypoint in stretch.waypoints:
            x_m, y_m = frames[stretch.floor].to_local(waypoint.latitude_deg, waypoint.longitude_deg)
            stream.write(f"{_ms(start_ms, waypoint.time_s)}\tTYPE_WAYPOINT\t{x_m:.4f}\t{y_m:.4f}\n".encode())


def _record(line: bytes, start_ms: int) -> tuple[float, bytes] | None:
    """Time and trace record of a line that a trace can hold; the others, and damaged ones, are of no use here."""
    kind = line[:4]
    try:
        if kind == b"WIFI":
            found = _WIFI.match(line)
            if found is None:
                return None
            time_s, ssid, bssid = float(found[1]), found[2].replace(b"\t", b" "), found[3].replace(b"-", b":")
            stamp = b"%d" % _ms(start_ms, time_s)
            # the sensor's own clock counts from another moment; the scan's time stands for when it was heard
            cells = (stamp, b"TYPE_WIFI", ssid, bssid, found[5], found[4] or b"0", stamp)
            return time_s, b"\t".join(cells) + b"\n"
        if kind in _SENSORS or kind == _ROTATION:
            cells_of = line.split(b";")
            time_s, first = float(cells_of[1]), 6 if kind == _ROTATION else 3
            values = [b"%.6g" % float(cell) for cell in cells_of[first : first + 3]]
            if len(values) < 3:
                return None
            name = _SENSORS.get(kind, b"TYPE_ROTATION_VECTOR")
            return time_s, b"\t".join((b"%d" % _ms(start_ms, time_s), name, *values, b"3")) + b"\n"
    except (ValueError, IndexError, OverflowError):
        return None
    return None


def _waypoint(cells: list[bytes]) -> Waypoint:
    time_s, latitude_deg, longitude_deg = float(cells[1]), float(cells[3]), float(cells[4])
    level, building = int(float(cells[5])), int(float(cells[6])) if len(cells) > 6 and cells[6] else 0
    if not (0.0 <= time_s < 1e7 and abs(latitude_deg) < 90.0 and abs(longitude_deg) <= 180.0):
        raise ValueError("time in seconds, latitude and longitude in degrees are expected")
    if latitude_deg == 0.0 and longitude_deg == 0.0:
        raise ValueError("latitude and longitude are 0: the place was not filled in")
    return Waypoint(time_s, latitude_deg, longitude_deg, f"B{building}F{level}", level)


def _created_ms(line: bytes) -> int | None:
    found = _CREATED.search(line)
    if found is None:
        return None
    month, day, clock, year = (part.decode() for part in found.groups())
    try:
        return 1000 * timegm(strptime(f"{month} {day} {year} {clock}", "%b %d %Y %H:%M:%S"))
    except ValueError:
        return None


def _ms(start_ms: int, time_s: float) -> int:
    return start_ms + round(1000.0 * time_s)
