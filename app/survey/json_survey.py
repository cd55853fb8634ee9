"""Surveys as JSON: `{"floor", "device", "fingerprints": [{"x", "y", "t", "readings": [{"bssid", "rssi"}]}]}`.

A fingerprint may also hold `"bluetooth": [{"id", "rssi"}]`, what was heard of beacons.

The body is read twice from its file and never held as a whole: first what surrounds the fingerprints, then those one by
one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import IO, Any

import ijson

from app.errors import InvalidInput, TooLarge
from app.survey.admission import (
    FloorExtent,
    PlaceReadings,
    SurveyNotes,
    checked_place,
    checked_time_ms,
    named_floor,
)
from app.wifi.fingerprint import Fingerprint

KEYS = ("floor", "device", "fingerprints")
DEVICE_KEYS = ("brand", "model")
LONGEST_NAME = 100
DEEPEST = 20
MOST_VALUES = 200_000
"""Values in one fingerprint, which is held as a whole while it is read."""


def read_json(
    first: IO[bytes], again: IO[bytes], floors: Mapping[str, FloorExtent], notes: SurveyNotes
) -> Iterator[Fingerprint]:
    """Fingerprints of a JSON survey as it is read; those that cannot be used are rejected by their path.

    Parameters
    ----------
    first, again : the same body from its start.

    Raises
    ------
    InvalidInput : no JSON, not an object, an unknown key, no floor, a device that is none.
    NotFound : the venue has no floor of that name.
    """
    surroundings = _surroundings(first)
    extent = named_floor(floors, surroundings.floor)
    notes.device = surroundings.device
    for index, item in enumerate(_items(again)):
        where = f"fingerprints[{index}]"
        try:
            readings = _place(item, extent)
        except ValueError as error:
            notes.rejections.add(where, str(error))
            continue
        for at, reading in enumerate(item["readings"]):
            try:
                _hear(readings, reading)
            except ValueError as error:
                notes.rejections.add(f"{where}.readings[{at}]", str(error))
        for at, reading in enumerate(item.get("bluetooth") or ()):
            try:
                _hear_beacon(readings, reading)
            except ValueError as error:
                notes.rejections.add(f"{where}.bluetooth[{at}]", str(error))
        if readings.rssi_by_bssid:
            yield readings.fingerprint()
        else:
            notes.rejections.add(where, "no reading that can be used")


class _Surroundings:
    """What a body holds beside its fingerprints, gathered event by event; refuses what cannot be a survey."""

    def __init__(self) -> None:
        self.floor: object = None
        self.device: dict[str, str] = {}
        self.has_fingerprints = False
        self._member = self._device_key = ""
        self._index, self._values = -1, 0

    @property
    def where(self) -> str:
        """The member that is being read, empty before the first."""
        return f"fingerprints[{max(self._index, 0)}]" if self._member == "fingerprints" else self._member

    def member(self, event: str, value: Any) -> None:
        """An event of the outermost object."""
        if event == "map_key":
            if value not in KEYS:
                raise InvalidInput(f"{value[:64]!r} is not known here", value[:64])
            self._member = value
        elif self._member == "fingerprints":
            self.has_fingerprints = True
            if event not in ("start_array", "end_array"):
                raise InvalidInput("fingerprints must be a list", "fingerprints")
        elif self._member == "floor":
            self.floor = value
        elif event not in ("start_map", "end_map", "null"):
            raise InvalidInput("device must be an object", "device")

    def inside(self, event: str, value: Any, depth: int) -> None:
        """An event deeper in."""
        if self._member == "fingerprints":
            if depth == 2 and not event.startswith("end"):
                self._index, self._values = self._index + 1, 0
            self._values += 1
            if self._values > MOST_VALUES:
                raise TooLarge(f"more than {MOST_VALUES} values in one fingerprint", f"fingerprints[{self._index}]")
        elif self._member == "device":
            if event == "map_key":
                if value not in DEVICE_KEYS:
                    raise InvalidInput(f"a device has brand and model, not {value[:64]!r}", "device")
                self._device_key = value
            elif event != "string":
                raise InvalidInput("must be text", f"device.{self._device_key}")
            else:  # some phones pad with NUL, which databases refuse
                self.device[self._device_key] = "".join(filter(str.isprintable, value))[:LONGEST_NAME]


def _surroundings(body: IO[bytes]) -> _Surroundings:
    found, depth = _Surroundings(), 0
    try:
        for event, value in ijson.basic_parse(body, use_float=True):
            if event.startswith("end"):
                depth -= 1
            if depth > 1:
                found.inside(event, value, depth)
            elif depth == 1:
                found.member(event, value)
            elif event not in ("start_map", "end_map"):
                raise InvalidInput("a survey is a JSON object")
            if event.startswith("start"):
                depth += 1
                if depth > DEEPEST:
                    raise InvalidInput(f"the body is nested more than {DEEPEST} deep")
    except (ijson.JSONError, UnicodeDecodeError, ValueError, OverflowError) as error:
        raise _not_read(error, found.where) from error
    if not found.has_fingerprints:
        raise InvalidInput("fingerprints are missing", "fingerprints")
    return found


def _items(body: IO[bytes]) -> Iterator[Any]:
    try:
        yield from ijson.items(body, "fingerprints.item", use_float=True)
    except (ijson.JSONError, UnicodeDecodeError, OverflowError, RecursionError) as error:
        raise _not_read(error, "fingerprints") from error


def _not_read(error: Exception, where: str) -> InvalidInput:
    """What is wrong with a body that cannot be read on. where : the member it was read up to."""
    said = error.args[0] if error.args else repr(error)  # yajl's words, in bytes where it shows a part of the body
    text = (said.decode(errors="replace") if isinstance(said, bytes) else str(said)).strip().splitlines()[0][:200]
    if "overflow" in text:  # valid JSON, but the parser cannot go on behind it (ICRAR/ijson issue 153)
        # without use_float it can, in twice the time, and crashes over an integer of more than 4300 digits
        remedy = "as it cannot be read on from there, nothing was stored: correct the number or leave it out"
        return InvalidInput(f"{where} holds a number that is larger than 64 bits hold; {remedy}", where)
    return InvalidInput(f"the body is not JSON: {text}", where)


def _place(item: object, extent: FloorExtent) -> PlaceReadings:
    if not isinstance(item, dict):
        raise ValueError("a fingerprint is an object of x, y, t and readings")
    x_m, y_m = checked_place(_number(item, "x"), _number(item, "y"), extent)
    if not isinstance(item.get("readings"), list):
        raise ValueError("readings must be a list")
    if not isinstance(item.get("bluetooth"), list | None):
        raise ValueError("bluetooth must be a list")
    return PlaceReadings(extent, x_m, y_m, checked_time_ms(_number(item, "t")) / 1000.0)


def _hear(readings: PlaceReadings, reading: object) -> None:
    if not isinstance(reading, dict) or not isinstance(reading.get("bssid"), str):
        raise ValueError("a reading is an object of bssid and rssi")
    ssid = reading.get("ssid")
    readings.hear(reading["bssid"], _number(reading, "rssi"), ssid if isinstance(ssid, str) else "")


def _hear_beacon(readings: PlaceReadings, reading: object) -> None:
    if not isinstance(reading, dict) or not isinstance(reading.get("id"), str):
        raise ValueError("a reading of a beacon is an object of id and rssi")
    readings.hear_beacon(reading["id"], _number(reading, "rssi"))


def _number(item: dict[str, Any], name: str) -> float:
    value = item.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{name} must be a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} is too large") from None
