"""Surveys as CSV: floor,x,y,t,bssid,rssi[,frequency][,ssid], one reading a row."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator, Mapping
from typing import IO

from app.errors import InvalidInput
from app.survey.admission import (
    FloorExtent,
    PlaceReadings,
    SurveyNotes,
    checked_place,
    checked_time_ms,
    known_floor,
)
from app.survey.rejection import Rejections
from app.wifi.fingerprint import Fingerprint

REQUIRED = ("floor", "x", "y", "t", "bssid", "rssi")
OPTIONAL = ("frequency", "ssid")
LONGEST_LINE = 100_000
"""Characters; a line that is longer is rejected, instead of taking memory."""


def read_csv(stream: IO[bytes], floors: Mapping[str, FloorExtent], notes: SurveyNotes) -> Iterator[Fingerprint]:
    """Fingerprints from consecutive rows of equal floor, x, y and t, one after the other as the file is read.

    A row is a line. Those that cannot be used are rejected by their number, the header being 1; columns may come in any
    order, cells in quotes.

    Raises
    ------
    InvalidInput : the header lacks a column, or has one that is not known.
    """
    text = io.TextIOWrapper(stream, encoding="utf-8-sig", errors="replace")
    rows = _rows(text, notes.rejections)
    _, header = next(rows, (0, []))
    column = _columns(header)
    place_of = tuple(column[name] for name in ("floor", "x", "y", "t"))
    bssid_at, rssi_at, ssid_at = column["bssid"], column["rssi"], column.get("ssid")
    key: tuple[str, ...] | None = None
    readings: PlaceReadings | None = None
    for line, row in rows:
        try:
            if len(row) != len(header):
                raise ValueError(f"{len(row)} cells where the header has {len(header)}")
            place = tuple([row[at] for at in place_of])
            if place != key:
                if readings is not None and readings.rssi_by_bssid:
                    yield readings.fingerprint()
                key, readings = None, None
                readings = _place(place, floors)
                key = place
            if readings is not None:
                ssid = "" if ssid_at is None else row[ssid_at]
                readings.hear(row[bssid_at].strip(), _number("rssi", row[rssi_at]), ssid)
        except ValueError as error:
            notes.rejections.add(line, str(error))
    if readings is not None and readings.rssi_by_bssid:
        yield readings.fingerprint()


def _rows(text: IO[str], rejections: Rejections) -> Iterator[tuple[int, list[str]]]:
    """Number and cells of every row. No cell spans lines, so a quote that is not closed costs its own line only."""
    for number, line in enumerate(_lines(text), start=1):
        if len(line) >= LONGEST_LINE:
            rejections.add(number, f"a row has fewer than {LONGEST_LINE} characters")
        elif row := line.rstrip("\n"):
            yield number, next(csv.reader((row,))) if '"' in row else row.split(",")


def _lines(text: IO[str]) -> Iterator[str]:
    """Every line, the first LONGEST_LINE characters of it."""
    while line := text.readline(LONGEST_LINE):
        yield line
        while line and line[-1] != "\n":
            line = text.readline(LONGEST_LINE)


def _columns(header: list[str]) -> dict[str, int]:
    names = [name.strip().lower() for name in header]
    for name in REQUIRED:
        if name not in names:
            must = ",".join(REQUIRED) + "".join(f"[,{one}]" for one in OPTIONAL)
            raise InvalidInput(f"the header has no column {name!r}; it must be {must}", name)
    for name in names:
        if name not in REQUIRED + OPTIONAL or names.count(name) > 1:
            raise InvalidInput(f"column {name[:64]!r} of the header is not known, or there twice", name[:64])
    return {name: at for at, name in enumerate(names)}


def _place(place: tuple[str, ...], floors: Mapping[str, FloorExtent]) -> PlaceReadings:
    extent = known_floor(floors, place[0].strip())
    x_m, y_m = checked_place(_number("x", place[1]), _number("y", place[2]), extent)
    return PlaceReadings(extent, x_m, y_m, checked_time_ms(_number("t", place[3])) / 1000.0)


def _number(name: str, cell: str) -> float:
    try:
        if "_" not in cell and cell.isascii():  # float() also reads 1_0, as ten, and digits of other scripts
            return float(cell)
    except ValueError:
        pass
    raise ValueError(f"{name} {cell[:40]!r} is not a number")
