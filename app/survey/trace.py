"""A recorded walk in the open data's format: tab-separated `unix_ms  TYPE  values...`, one record a line.

Real files break that rule: records lose their newline, a BSSID occurs twice in a scan, times are stale, SSIDs hold
anything. What cannot be read is left out with its line and reason; the rest of the walk stands.
"""

from __future__ import annotations

import io
import re
from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import IO

import numpy as np

from app.errors import InvalidInput
from app.estimation.arrays import FloatArray
from app.observations import AxisSamples, BluetoothScan, WifiScan
from app.survey.admission import LATEST_MS, OPT_OUT, RSSI_RANGE_DBM, checked_rssi, checked_time_ms
from app.survey.rejection import Rejection, Rejections
from app.survey.trace_columns import BeaconRecords, axis_samples, table, wifi_scans
from app.survey.unpacking import Allowance, damage_named, unpacked
from app.wifi.bssid import parse_bssid

LARGEST_VALUE = 1e6
"""Bound of any sensor value and coordinate, in its unit; also keeps out what is not finite."""

LONGEST_LINE = 1 << 20
"""Bytes; a longer one (a file without any newline) is cut, which costs the record at the cut."""
MOST_WAYPOINTS = 100_000
"""In one walk; more is no walk but a way to take memory."""
MOST_STRAY_LINES = 100_000
"""That are no record, in one file; more is no log, and a little compressed file could hold a worker for hours."""

_RECORD = re.compile(rb"(?=\d{13}\tTYPE_)")
_STREAMS = {
    b"TYPE_ACCELEROMETER": "accelerometer",
    b"TYPE_GYROSCOPE": "gyroscope",
    b"TYPE_MAGNETIC_FIELD": "magnetometer",
    b"TYPE_ROTATION_VECTOR": "rotation_vector",
}
_SAMPLE_CELLS = 6  # time, type, x, y, z, accuracy
_WIFI, _BEACON, _WAYPOINT = b"TYPE_WIFI", b"TYPE_BEACON", b"TYPE_WAYPOINT"
_OPT_OUT = OPT_OUT.encode()


@dataclass(frozen=True, slots=True)
class Device:
    """What recorded the walk; empty where the header does not say."""

    brand: str = ""
    model: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """One walk of one surveyor.

    trace : file name up to its first dot.  waypoint_time_s : (w,) increasing.  waypoint_xy_m : (w, 2) in the floor's
    frame.  scans, bluetooth : in the order of time.  rejected : the first unreadable records; rejected_count : all.
    """

    trace: str
    device: Device
    waypoint_time_s: FloatArray
    waypoint_xy_m: FloatArray
    accelerometer: AxisSamples
    gyroscope: AxisSamples
    magnetometer: AxisSamples
    rotation_vector: AxisSamples
    scans: tuple[WifiScan, ...]
    rejected: tuple[Rejection, ...] = ()
    rejected_count: int = 0
    bluetooth: tuple[BluetoothScan, ...] = ()


def read_trace(content: IO[bytes] | bytes, name: str) -> Trace:
    """Read one trace, plain or compressed.

    Raises
    ------
    InvalidInput : damaged compression, no record at all, or a zip that does not hold exactly one trace.
    TooLarge : beyond the bounds of unpacking.py.
    """
    traces = list(read_traces(content, name))
    if len(traces) != 1:
        raise InvalidInput(f"{name}: {len(traces)} traces where one is expected", name)
    return traces[0]


def read_traces(content: IO[bytes] | bytes, name: str, allowance: Allowance | None = None) -> Iterator[Trace]:
    """Every trace of a file: one, or all those of a zip. Raises as read_trace does.

    allowance : what unpacking may still cost, shared by the files of one survey.
    """
    stream = io.BytesIO(content) if isinstance(content, bytes) else content
    for member, lines in unpacked(stream, name, allowance or Allowance()):
        with damage_named(member):
            trace = _Reader(member).read(lines)
        yield trace


class _Reader:
    """Collects the records of one trace, samples and readings as packed numbers: a log of hours must fit in memory."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._device: dict[str, str] = {}
        self._samples = {kind: array("d") for kind in _STREAMS}  # time_ms, x, y, z
        self._readings = array("d")  # time_ms, bssid, seen_ms, rssi_dbm
        self._beacons = BeaconRecords()
        self._waypoints: dict[int, tuple[float, float]] = {}
        self._rejections = Rejections()
        self._records = 0
        self._stray_lines = 0

    def read(self, lines: IO[bytes]) -> Trace:
        samples_of = self._samples.get
        for number, line in enumerate(iter(partial(lines.readline, LONGEST_LINE), b""), start=1):
            cells = line.split(b"\t")
            # the bulk of a log, without a call; more cells than these may be records that lost their newline
            if len(cells) == _SAMPLE_CELLS and (samples := samples_of(cells[1])) is not None:
                try:
                    time_ms, x, y, z = int(cells[0]), float(cells[2]), float(cells[3]), float(cells[4])
                except ValueError:
                    self._record(cells, number)
                    continue
                if abs(x) + abs(y) + abs(z) < LARGEST_VALUE and 0 <= time_ms < LATEST_MS:
                    samples.extend((time_ms, x, y, z))
                    self._records += 1
                    continue
            if len(cells) > _SAMPLE_CELLS and line.find(b"\tTYPE_", 14) > 0:
                for record in _RECORD.split(line):
                    self._record(record.split(b"\t"), number)
            else:
                self._record(cells, number)
        if not self._records:
            raise InvalidInput(f"{self._name}: not a trace: it holds no record `unix_ms<tab>TYPE_...`", self._name)
        return self._trace()

    def _record(self, cells: list[bytes], number: int) -> None:
        kind = cells[1] if len(cells) > 1 else b""
        if not kind.startswith(b"TYPE_"):
            self._stray_lines += 1
            if self._stray_lines > MOST_STRAY_LINES:
                raise InvalidInput(f"{self._name}: more than {MOST_STRAY_LINES:,} lines are no record", self._name)
            if cells[0].startswith(b"#"):
                self._header(b"\t".join(cells))
            elif any(map(bytes.strip, cells)):
                self._reject(number, "not a record: `unix_ms<tab>TYPE_...` expected")
            return
        self._records += 1
        try:
            samples = self._samples.get(kind)
            if samples is not None:
                time_ms, x, y, z = int(cells[0]), float(cells[2]), float(cells[3]), float(cells[4])
                if not abs(x) + abs(y) + abs(z) < LARGEST_VALUE:
                    raise ValueError("values must be finite and below 1e6")
                if not 0 <= time_ms < LATEST_MS:
                    checked_time_ms(time_ms)
                samples.extend((time_ms, x, y, z))
            elif kind == _WIFI:
                self._reading(cells)
            elif kind == _BEACON:
                self._beacons.read(cells)
            elif kind == _WAYPOINT:
                self._waypoint(cells)
        except (ValueError, IndexError) as error:
            text = "too few cells" if isinstance(error, IndexError) else str(error)
            self._reject(number, f"{kind.decode('ascii', 'replace')[:64]}: {text}")

    def _reading(self, cells: list[bytes]) -> None:
        if len(cells) < 7:
            raise IndexError
        # SSIDs may hold tabs: the last four cells are counted from the right
        if cells[-5].endswith(_OPT_OUT):
            return
        time_ms, rssi_dbm, seen_ms = int(cells[0]), float(cells[-3]), int(cells[-1])
        if not (RSSI_RANGE_DBM[0] <= rssi_dbm <= RSSI_RANGE_DBM[1] and 0 <= time_ms < LATEST_MS):
            checked_rssi(rssi_dbm)
            checked_time_ms(time_ms)
        bssid = _address(cells[-4])
        # some phones do not say when (0), or run ahead of the scan
        seen_ms = min(seen_ms, time_ms) if seen_ms > 0 else time_ms
        self._readings.extend((time_ms, bssid, seen_ms, rssi_dbm))

    def _waypoint(self, cells: list[bytes]) -> None:
        time_ms, x, y = _time_ms(cells[0]), float(cells[2]), float(cells[3])
        if not abs(x) + abs(y) < LARGEST_VALUE:
            raise ValueError("coordinates must be finite and below 1e6 m")
        if len(self._waypoints) >= MOST_WAYPOINTS:
            raise ValueError(f"more than {MOST_WAYPOINTS} waypoints in one walk")
        if self._waypoints.setdefault(time_ms, (x, y)) != (x, y):
            raise ValueError("a second place at the time of an earlier waypoint")

    def _header(self, line: bytes) -> None:
        for cell in line.decode("utf-8", "replace").lstrip("#").strip().split("\t"):
            key, _, value = cell.partition(":")
            if key in ("Brand", "Model"):
                self._device.setdefault(key, "".join(filter(str.isprintable, value)).strip()[:100])

    def _reject(self, number: int, reason: str) -> None:
        self._rejections.add(f"{self._name}:{number}", reason)

    def _trace(self) -> Trace:
        waypoints = sorted(self._waypoints.items())
        return Trace(
            trace=walk_of(self._name),
            device=Device(self._device.get("Brand", ""), self._device.get("Model", "")),
            waypoint_time_s=np.array([time_ms for time_ms, _ in waypoints], dtype=np.float64) / 1000.0,
            waypoint_xy_m=np.array([place for _, place in waypoints], dtype=np.float64).reshape(-1, 2),
            scans=wifi_scans(table(self._readings)),
            rejected=tuple(self._rejections.listed),
            rejected_count=self._rejections.count,
            bluetooth=self._beacons.scans(),
            **{_STREAMS[kind]: axis_samples(table(rows)) for kind, rows in self._samples.items()},
        )


def walk_of(name: str) -> str:
    """The id of a trace: its file name, without folders, up to the first dot."""
    return name.rsplit("/", 1)[-1].split(".")[0]


@lru_cache(1 << 16)
def _address(cell: bytes) -> int:
    return parse_bssid(cell.decode("ascii", "replace"))


def _time_ms(cell: bytes) -> int:
    return int(checked_time_ms(int(cell)))
