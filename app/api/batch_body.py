"""The wire schema of a batch, and from its bytes to app.observations.Batch."""

from __future__ import annotations

import json
import secrets
from typing import Annotated, Any, NotRequired

import numpy as np
import ormsgpack
from pydantic import BaseModel, FailFast, Field, TypeAdapter, ValidationError
from typing_extensions import TypedDict

from app.api.batch_columns import axis_samples, pressure_samples, refuse_scattered
from app.api.batch_scans import bluetooth_scans, wifi_scans
from app.api.decoding import Packing
from app.api.json_bodies import FROM_PHONES, refusal
from app.errors import InvalidInput, TooLarge
from app.observations import AxisSamples, Batch, PressureSamples
from app.survey.admission import LATEST_MS

LARGEST_COLUMN = 200_000
LARGEST_SCAN_LIST = 600
LARGEST_SCAN = 2_000
LARGEST_SEQUENCE = 2**31 - 1

Column = Annotated[list[float], FailFast(), Field(max_length=LARGEST_COLUMN)]
Instant = Annotated[float, Field(ge=1, le=LATEST_MS, description="Unix epoch milliseconds of the phone's clock.")]

Reported = Annotated[float, Field(allow_inf_nan=True)]
"""Of a reading: phones say anything here, and one odd number must not cost a batch."""


class AxisColumns(BaseModel):
    """A three-axis stream in the Android device frame: columns of equal length, ordered by time."""

    model_config = FROM_PHONES

    t: Column
    x: Column
    y: Column
    z: Column


class PressureColumns(BaseModel):
    """The barometer, hPa. A pressure outside 100 to 1200 is dropped and counted: real ones break and say 0."""

    model_config = FROM_PHONES

    t: Column
    pressure: Column


class WifiReading(TypedDict):
    """One access point of a scan. `bssid` may be anything; what cannot be parsed is dropped and counted, as an `rssi`
    is that no phone measures. `seen` counts where it is a time before the scan's, `frequency` not at all."""

    __pydantic_config__ = FROM_PHONES  # type: ignore[misc]

    bssid: NotRequired[Any]
    rssi: Reported
    frequency: NotRequired[Reported | None]
    seen: NotRequired[Reported | None]


class WifiScanBody(BaseModel):
    """One WiFi scan, as delivered at `t`."""

    model_config = FROM_PHONES

    t: Instant
    readings: Annotated[list[WifiReading], FailFast(), Field(max_length=LARGEST_SCAN)]


class BluetoothReading(TypedDict):
    """One beacon of a scan; likewise. `tx_power` does not count."""

    __pydantic_config__ = FROM_PHONES  # type: ignore[misc]

    id: NotRequired[Any]
    rssi: Reported
    tx_power: NotRequired[Reported | None]


class BluetoothScanBody(BaseModel):
    """One Bluetooth scan, as delivered at `t`."""

    model_config = FROM_PHONES

    t: Instant
    readings: Annotated[list[BluetoothReading], FailFast(), Field(max_length=LARGEST_SCAN)]


class BatchBody(BaseModel):
    """What a phone reports at once. Every stream is optional; unknown fields are ignored.

    As `application/msgpack` the same fields; a column may also be packed as `bin`: little-endian float64, or float32
    for a column other than `t`, told apart by the length of `t`.
    """

    model_config = FROM_PHONES

    sequence: Annotated[int, Field(ge=0, le=LARGEST_SEQUENCE, description="0, 1, 2, ...")]
    end: Annotated[
        Instant | None, Field(description="Up to when the phone has reported; default: the newest sample.")
    ] = None
    accelerometer: Annotated[AxisColumns | None, Field(description="m/s^2, at most 400 in magnitude")] = None
    gyroscope: Annotated[AxisColumns | None, Field(description="rad/s, at most 100 in magnitude")] = None
    magnetometer: Annotated[AxisColumns | None, Field(description="microtesla, at most 10,000 in magnitude")] = None
    rotation_vector: Annotated[AxisColumns | None, Field(description="x, y, z of Android's unit quaternion")] = None
    barometer: Annotated[PressureColumns | None, Field(description="hPa")] = None
    wifi: Annotated[list[WifiScanBody], Field(max_length=LARGEST_SCAN_LIST)] | None = None
    bluetooth: Annotated[list[BluetoothScanBody], Field(max_length=LARGEST_SCAN_LIST)] | None = None


BATCH = TypeAdapter(BatchBody)
_AXES = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")
_MARK = secrets.token_bytes(8)
_PAIR, _END = b"\x92", ormsgpack.packb(_MARK)
"""What a body stands between, so that they are a pair of it and the mark exactly where nothing else follows it."""
_COLUMNS = {**dict.fromkeys(_AXES, ("t", "x", "y", "z")), "barometer": ("t", "pressure")}


def parse_batch(sent: bytes, packing: Packing) -> Batch:
    """The batch in a body.

    Raises
    ------
    InvalidInput : cannot be used; names the first offending field, e.g. `accelerometer.t[17]`.
    TooLarge : a list is longer than its bound; names it.
    """
    try:
        body = _parse_json(sent) if packing is Packing.JSON else BATCH.validate_python(_unpack(sent))
    except ValidationError as error:
        raise refusal(error) from error
    return _batch_of(body)


def _parse_json(sent: bytes) -> BatchBody:
    """The body in JSON. Half a character (a lone surrogate), which fast parsers refuse, is no reason to lose a batch:
    real SSIDs and BSSIDs hold it, and a reading that cannot be parsed is dropped further on."""
    try:
        return BATCH.validate_json(sent)
    except ValidationError as error:
        if error.errors(include_input=False)[0]["type"] != "json_invalid" or b"\\ud" not in sent.lower():
            raise
        try:
            lenient = json.loads(sent)
        except (ValueError, RecursionError):
            raise error from None
        return BATCH.validate_python(lenient)


def _unpack(sent: bytes) -> Any:
    """A MessagePack body with its packed columns as lists."""
    try:
        body, *end = ormsgpack.unpackb(_PAIR + sent + _END)
    except ValueError as error:
        raise InvalidInput(f"the body is not MessagePack: {error}") from error
    if end != [_MARK]:  # the parser itself does not mind what follows
        raise InvalidInput("the body is not one MessagePack object: it is cut short, or more follows it")
    if not isinstance(body, dict):
        return body
    for stream, columns in _COLUMNS.items():
        sent_columns = body.get(stream)
        if isinstance(sent_columns, dict):
            t = sent_columns.get("t")
            length = len(t) // 8 if isinstance(t, bytes) else len(t) if isinstance(t, list) else 0
            for name in columns:
                if isinstance(packed := sent_columns.get(name), bytes):
                    sent_columns[name] = _unpacked_column(f"{stream}.{name}", packed, length)
    return body


def _unpacked_column(field: str, packed: bytes, length: int) -> list[float]:
    if len(packed) > 8 * LARGEST_COLUMN:
        raise TooLarge(f"a column has at most {LARGEST_COLUMN} values", field)
    if len(packed) == 8 * length:
        return list(np.frombuffer(packed, "<f8").tolist())
    if len(packed) == 4 * length and not field.endswith(".t"):
        return list(np.frombuffer(packed, "<f4").tolist())
    raise InvalidInput(f"{len(packed)} bytes are not {length} values of float64 or float32, one for each of t", field)


def _batch_of(body: BatchBody) -> Batch:
    wifi, wifi_dropped = wifi_scans([scan.t for scan in body.wifi or ()], [scan.readings for scan in body.wifi or ()])
    bluetooth, bluetooth_dropped = bluetooth_scans(
        [scan.t for scan in body.bluetooth or ()], [scan.readings for scan in body.bluetooth or ()]
    )
    barometer, pressures_dropped = _pressure_samples(body.barometer)
    times = _times_ms(body)
    end_ms = body.end if body.end is not None else max((last for _, last in times.values()), default=None)
    batch = Batch(
        sequence=body.sequence,
        end_s=None if end_ms is None else end_ms / 1000.0,
        accelerometer=_axis_samples("accelerometer", body.accelerometer),
        gyroscope=_axis_samples("gyroscope", body.gyroscope),
        magnetometer=_axis_samples("magnetometer", body.magnetometer),
        rotation_vector=_axis_samples("rotation_vector", body.rotation_vector),
        barometer=barometer,
        wifi=wifi,
        bluetooth=bluetooth,
        dropped=wifi_dropped + bluetooth_dropped + pressures_dropped,
    )
    refuse_scattered(times, body.end)
    return batch


def _times_ms(body: BatchBody) -> dict[str, tuple[float, float]]:
    """First and last time of every stream that has any, by the field that holds them."""
    times = {}
    for name in _COLUMNS:
        columns = getattr(body, name)
        if columns is not None and columns.t:
            times[f"{name}.t"] = (columns.t[0], columns.t[-1])
    for name in ("wifi", "bluetooth"):
        scans = getattr(body, name)
        if scans:
            times[name] = (scans[0].t, scans[-1].t)
    return times


def _axis_samples(name: str, columns: AxisColumns | None) -> AxisSamples:
    return AxisSamples() if columns is None else axis_samples(name, columns.t, columns.x, columns.y, columns.z)


def _pressure_samples(columns: PressureColumns | None) -> tuple[PressureSamples, int]:
    return (PressureSamples(), 0) if columns is None else pressure_samples(columns.t, columns.pressure)
