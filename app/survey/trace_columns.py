"""Packed records of a trace as streams and scans, in order of time."""

from __future__ import annotations

from array import array

import numpy as np

from app.estimation.arrays import FloatArray
from app.observations import AxisSamples, BluetoothScan, WifiScan
from app.survey.admission import checked_rssi, checked_time_ms
from app.wifi.beacons import LISTENING_S

MOST_BEACONS = 100_000
"""Different ones in one walk; more is no walk but a way to take memory."""
LONGEST_UUID = 40


class BeaconRecords:
    """Collects the beacons of one trace, readings as packed numbers."""

    def __init__(self) -> None:
        self._number: dict[str, int] = {}
        self._readings = array("d")  # time_ms, number of the beacon, rssi_dbm

    def read(self, cells: list[bytes]) -> None:
        """Take a record `time, type, uuid, major, minor, tx_power, rssi, distance, address, ...`.

        Raises
        ------
        ValueError, IndexError : it is none.
        """
        time_ms, tx_power_dbm, rssi_dbm = checked_time_ms(int(cells[0])), float(cells[5]), checked_rssi(float(cells[6]))
        if not abs(tx_power_dbm) <= 127.0:
            raise ValueError("the transmit power must be within +-127 dBm")
        beacon = beacon_id(cells)
        number = self._number.get(beacon)
        if number is None:
            if len(self._number) >= MOST_BEACONS:
                raise ValueError(f"more than {MOST_BEACONS} beacons in one walk")
            number = self._number[beacon] = len(self._number)
        self._readings.extend((time_ms, number, rssi_dbm))

    def scans(self) -> tuple[BluetoothScan, ...]:
        """What was heard within LISTENING_S of its first reading, as a scan delivered with its last one."""
        rows, names = table(self._readings, 3), tuple(self._number)
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
        time_s, found, begin = rows[:, 0] / 1000.0, [], 0
        while begin < len(rows):
            end = int(np.searchsorted(time_s, time_s[begin] + LISTENING_S, side="right"))
            heard = rows[begin:end]
            found.append(
                BluetoothScan(
                    time_s=float(time_s[end - 1]),
                    beacon=tuple(names[int(number)] for number in heard[:, 1]),
                    rssi_dbm=heard[:, 2].copy(),
                )
            )
            begin = end
        return tuple(found)


def beacon_id(cells: list[bytes]) -> str:
    """`uuid:major:minor` of a record. Where major and minor are both 0 nobody has numbered the beacons: they differ by
    address alone, which then is part of the identifier, `uuid:0:0:address`.

    Raises
    ------
    ValueError, IndexError : the record names no beacon.
    """
    uuid, major, minor = (cell.strip().decode("ascii") for cell in cells[2:5])
    address = cells[8].strip().decode("ascii")
    if not (uuid and major.isdigit() and minor.isdigit() and len(uuid) <= LONGEST_UUID):
        raise ValueError("uuid, major and minor are expected")
    parts = [uuid, major, minor] if int(major) or int(minor) else [uuid, major, minor, address[:LONGEST_UUID]]
    return ":".join(parts).lower()


def table(rows: array[float], columns: int = 4) -> FloatArray:
    """(n, columns) of packed rows."""
    return np.frombuffer(rows, dtype=np.float64).reshape(-1, columns)


def wifi_scans(readings: FloatArray) -> tuple[WifiScan, ...]:
    """Readings (n, 4) of equal time as scans. Of one that occurs twice the last `seen` counts, ties the stronger."""
    if not len(readings):
        return ()
    time_ms, bssid, seen_ms, rssi_dbm = readings[np.lexsort(readings.T[[3, 2, 1, 0]])].T
    starts = np.flatnonzero(np.diff(time_ms, prepend=-1.0))
    last_of = np.append((np.diff(time_ms) != 0.0) | (np.diff(bssid) != 0.0), True)
    return tuple(
        WifiScan(
            time_s=float(time_ms[begin]) / 1000.0,
            bssid=bssid[begin:end][last_of[begin:end]].astype(np.int64),
            rssi_dbm=rssi_dbm[begin:end][last_of[begin:end]],
            seen_s=seen_ms[begin:end][last_of[begin:end]] / 1000.0,
        )
        for begin, end in zip(starts, np.append(starts[1:], len(time_ms)), strict=True)
    )


def axis_samples(rows: FloatArray) -> AxisSamples:
    """Rows (n, 4) of time_ms, x, y, z as a stream in order of time."""
    if np.any(np.diff(rows[:, 0]) < 0.0):
        rows = rows[np.argsort(rows[:, 0], kind="stable")]
    return AxisSamples(time_s=rows[:, 0] / 1000.0, values=rows[:, 1:].copy())
