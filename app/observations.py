"""The nouns that all layers share: what a phone sends in, and the Fix that goes back.

Inside the service every time is Unix seconds of the phone's clock, every length metres, every angle radians clockwise
from north in (-pi, pi]; milliseconds exist at the wire only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from app.estimation.arrays import FloatArray, IntArray

ABSOLUTE_BELOW_RAD = 1.0
"""Headings of a larger standard deviation are not from north."""


def _empty_times() -> FloatArray:
    return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class AxisSamples:
    """A three-axis sensor stream in the Android device frame.

    time_s : (n,) non-decreasing.  values : (n, 3), unit by stream: m/s^2, rad/s, microtesla; for the rotation vector
    x, y, z of the unit quaternion (device to east-north-up).
    """

    time_s: FloatArray = field(default_factory=_empty_times)
    values: FloatArray = field(default_factory=lambda: np.empty((0, 3)))


@dataclass(frozen=True, slots=True, eq=False)
class PressureSamples:
    """Barometer stream. time_s : (n,) non-decreasing.  pressure_hpa : (n,)."""

    time_s: FloatArray = field(default_factory=_empty_times)
    pressure_hpa: FloatArray = field(default_factory=_empty_times)


@dataclass(frozen=True, slots=True, eq=False)
class WifiScan:
    """One WiFi scan; each access point occurs once.

    time_s : when the scan was delivered.  bssid : (n,) 48-bit MAC addresses as integers.  rssi_dbm : (n,).
    seen_s : (n,) when each access point was last heard, at most time_s (phones repeat stale ones).
    """

    time_s: float
    bssid: IntArray
    rssi_dbm: FloatArray
    seen_s: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class BluetoothScan:
    """One Bluetooth scan: identifiers and RSSI, both of length n."""

    time_s: float
    beacon: tuple[str, ...]
    rssi_dbm: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """What one phone reports at once, validated: columns finite, equally long and ordered in time.

    end_s : up to when the phone has reported; None for an empty batch that does not say.
    dropped : readings and pressures that could not be used and were left out at the door.
    """

    sequence: int
    end_s: float | None
    accelerometer: AxisSamples = field(default_factory=AxisSamples)
    gyroscope: AxisSamples = field(default_factory=AxisSamples)
    magnetometer: AxisSamples = field(default_factory=AxisSamples)
    rotation_vector: AxisSamples = field(default_factory=AxisSamples)
    barometer: PressureSamples = field(default_factory=PressureSamples)
    wifi: tuple[WifiScan, ...] = ()
    bluetooth: tuple[BluetoothScan, ...] = ()
    dropped: int = 0
    gap: bool = False

    @property
    def size(self) -> int:
        """Samples of all streams and readings of all scans together: how much work it is."""
        streams = (self.accelerometer, self.gyroscope, self.magnetometer, self.rotation_vector, self.barometer)
        samples = sum(stream.time_s.size for stream in streams)
        readings = sum(scan.rssi_dbm.size for scan in self.wifi) + sum(scan.rssi_dbm.size for scan in self.bluetooth)
        return samples + readings


@dataclass(frozen=True, slots=True)
class Step:
    """One detected step.

    time_s : instant of the step.  duration_s : since the previous step (or the stride period's estimate).
    length_m : by the step-length model before any learned scale.  heading_rad : walking direction.
    heading_sigma_rad : its standard deviation.  heading_change_rad : change since the previous step by the gyroscope
    alone.  magnetic_heading_rad : by the magnetometer, or NaN.  push_rad : from where the phone points to where the
    step pushed it, clockwise, or NaN (app/pdr/push.py).
    """

    time_s: float
    duration_s: float
    length_m: float
    heading_rad: float
    heading_sigma_rad: float
    heading_change_rad: float
    magnetic_heading_rad: float
    push_rad: float = math.nan

    @property
    def absolute(self) -> bool:
        """Whether its heading is from north."""
        return self.heading_sigma_rad < ABSOLUTE_BELOW_RAD


@dataclass(frozen=True, slots=True, eq=False)
class InnovationCheck:
    """The record that every measurement leaves, fused or not.

    innovation and sigma : (m,) in the units of the measurement; statistic is compared with threshold.
    """

    source: str
    time_s: float
    innovation: FloatArray
    sigma: FloatArray
    statistic: float
    threshold: float
    rejected: bool
    fused: bool


@dataclass(frozen=True, slots=True, eq=False)
class RadioFix:
    """Where one scan alone puts the phone, before anybody asked the steps.

    xy_m : (2,) on the floor.  noise_m2 : (2, 2) the part of its error that is its own.  lasting_m2 : variance in each
    direction of the part that the scans around share.  signal_distance : to the best of the map, in the matcher's unit.
    fits : whether the track that is answered from bears it out.  source : `wifi` or `bluetooth`.
    """

    time_s: float
    floor: str
    xy_m: FloatArray
    noise_m2: FloatArray
    lasting_m2: float
    signal_distance: float
    fits: bool
    source: str = "wifi"


class Flag(StrEnum):
    """Integrity flag of a Fix; docs/conventions.md defines each."""

    INITIALISING = "initialising"
    NOMINAL = "nominal"
    CORRECTED = "corrected"
    OUTLIER = "outlier"
    FAULT = "fault"
    COASTING = "coasting"


class Motion(StrEnum):
    """What the walker does, from the inertial streams."""

    STILL = "still"
    WALKING = "walking"
    UNKNOWN = "unknown"


class Carrying(StrEnum):
    """Where the phone is carried."""

    HANDHELD = "handheld"
    POCKET = "pocket"
    CALL = "call"
    SWINGING = "swinging"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Excluded:
    """An observation or access point left out of the estimate, and why."""

    reason: str
    observation: str | None = None
    bssid: int | None = None


@dataclass(frozen=True, slots=True)
class Integrity:
    """Whether the answer can be trusted. The level is None exactly while there is no position."""

    flag: Flag
    usable: bool
    if1: int
    if2: int
    if3: int
    statistic: float | None
    threshold: float | None
    protection_level_m: float | None
    alert_limit_m: float
    risk: float
    excluded: tuple[Excluded, ...] = ()


@dataclass(frozen=True, slots=True)
class Position:
    """A place in a floor's local frame: x east, y north, metres."""

    x_m: float
    y_m: float
    floor: str


@dataclass(frozen=True, slots=True, eq=False)
class Fix:
    """The answer to a batch: the best estimate *at* time_s.

    accuracy_m : 68 % radius.  covariance_m2 : ((xx, xy), (xy, yy)).  All estimates are None while position is None;
    heading and speed may still be unknown after that.
    checks, evidence : what was measured since the Fix before, in the order in which it came: for evaluation, smoothing
    and the watch over radio maps; never part of the answer.
    confirmed : access points that these scans heard as they were surveyed, once for each scan; likewise.
    floor_certain : whether the floor may be relied upon.  unsurveyed_m2 : variance in each direction that scans have
    had lately beyond what scans of surveyed places have. The level holds both already.
    """

    time_s: float | None
    position: Position | None
    accuracy_m: float | None
    covariance_m2: tuple[tuple[float, float], tuple[float, float]] | None
    heading_rad: float | None
    speed_mps: float | None
    step_count: int
    motion: Motion
    carrying: Carrying
    integrity: Integrity
    checks: tuple[InnovationCheck, ...] = ()
    evidence: tuple[Step | RadioFix, ...] = ()
    confirmed: tuple[int, ...] = ()
    floor_certain: bool = True
    unsurveyed_m2: float = 0.0
