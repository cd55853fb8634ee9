"""Reading whole survey bodies in tests."""

from __future__ import annotations

import io
from collections.abc import Mapping

from app.survey.admission import FloorExtent, SurveyNotes
from app.survey.csv_survey import read_csv
from app.survey.json_survey import read_json
from app.survey.trace_survey import read_walks
from app.wifi.bssid import format_bssid
from app.wifi.fingerprint import Fingerprint

FLOORS = {"F1": FloorExtent("F1", 100.0, 60.0), "B1": FloorExtent("B1", None, None)}
Read = tuple[list[Fingerprint], SurveyNotes]


def csv_survey(content: str | bytes) -> Read:
    """Fingerprints of a CSV, and the notes."""
    notes = SurveyNotes()
    sent = content.encode() if isinstance(content, str) else content
    return list(read_csv(io.BytesIO(sent), FLOORS, notes)), notes


def json_survey(content: bytes) -> Read:
    """Fingerprints of a JSON body, and the notes."""
    notes = SurveyNotes()
    return list(read_json(io.BytesIO(content), io.BytesIO(content), FLOORS, notes)), notes


def walks_survey(files: Mapping[str, bytes], floor: str = "F1") -> Read:
    """Fingerprints of trace files, and the notes."""
    notes = SurveyNotes()
    streams = ((name, io.BytesIO(content)) for name, content in files.items())
    return list(read_walks(streams, FLOORS[floor], notes)), notes


def levels(fingerprint: Fingerprint) -> dict[str, float]:
    """RSSI by address."""
    pairs = zip(fingerprint.bssid.tolist(), fingerprint.rssi_dbm.tolist(), strict=True)
    return {format_bssid(bssid): rssi_dbm for bssid, rssi_dbm in pairs}


def reasons(notes: SurveyNotes) -> dict[str | int, str]:
    """Reason of each rejection by its item."""
    return {one.item: one.reason for one in notes.rejections.listed}
