"""A survey as it was sent, lying in files, and reading it: what a worker process does with an upload."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import IO, Any

from app.errors import InvalidInput
from app.survey.admission import FloorExtent, SurveyNotes, named_floor
from app.survey.csv_survey import read_csv
from app.survey.json_survey import read_json
from app.survey.rejection import Rejection
from app.survey.spool import row_of, write_row
from app.survey.trace_survey import read_walks
from app.wifi.fingerprint import Fingerprint

REASONS_SHOWN = 3
"""Rejections quoted where nothing of a survey can be used."""


class SurveyFormat(StrEnum):
    """How a survey was sent; the value is stored with it."""

    JSON = "json"
    CSV = "csv"
    TRACES = "traces"
    GEOSUBMIT = "geosubmit"


@dataclass(frozen=True, slots=True)
class Upload:
    """Files of a survey. Several only of traces.

    files : name as sent, and where it lies.  floor : of traces, which do not say themselves.
    """

    format: SurveyFormat
    files: tuple[tuple[str, Path], ...]
    floor: str | None = None


@dataclass(frozen=True, slots=True)
class SurveyFindings:
    """What an upload was found to hold.

    per_floor : fingerprints.  rejected : the first rejections; rejected_count : all of them.
    """

    device: Mapping[str, Any]
    per_floor: Mapping[str, int]
    rejected: tuple[Rejection, ...] = field(default=())
    rejected_count: int = 0

    @property
    def accepted(self) -> int:
        """Fingerprints that can be used."""
        return sum(self.per_floor.values())


class UselessSurvey(InvalidInput):
    """No fingerprint of an upload can be used; rejected and rejected_count as in SurveyFindings."""

    # the defaults are for pickling, which makes it of the message alone and then gives it the rest
    def __init__(
        self, message: str, field: str = "", rejected: tuple[Rejection, ...] = (), rejected_count: int = 0
    ) -> None:
        super().__init__(message, field)
        self.rejected, self.rejected_count = rejected, rejected_count


def read_upload(upload: Upload, floors: Mapping[str, FloorExtent], spool: Path) -> SurveyFindings:
    """Read an upload from its files and write its fingerprints to a spool.

    Parameters
    ----------
    floors : of the venue, by name.

    Raises
    ------
    InvalidInput : the upload is not in its format.
    NotFound : the venue has no floor of the name that the upload as a whole is of.
    UselessSurvey : it has not a single fingerprint that can be used.
    """
    notes, per_floor = SurveyNotes(), Counter[str]()
    with spool.open("wb") as out:
        for fingerprint in _fingerprints(upload, floors, notes):
            write_row(out, row_of(fingerprint))
            per_floor[fingerprint.floor] += 1
    rejections = notes.rejections
    if not per_floor:
        raise _useless(upload, rejections.listed, rejections.count)
    return SurveyFindings(notes.device, dict(per_floor), tuple(rejections.listed), rejections.count)


def _fingerprints(upload: Upload, floors: Mapping[str, FloorExtent], notes: SurveyNotes) -> Iterator[Fingerprint]:
    if upload.format is SurveyFormat.TRACES:
        yield from read_walks(_opened(upload), named_floor(floors, upload.floor), notes)
        return
    with ExitStack() as stack:
        ((_, path),) = upload.files
        first, again = (stack.enter_context(path.open("rb")) for _ in range(2))
        if upload.format is SurveyFormat.CSV:
            yield from read_csv(first, floors, notes)
        else:
            yield from read_json(first, again, floors, notes)


def _opened(upload: Upload) -> Iterator[tuple[str, IO[bytes]]]:
    for name, path in upload.files:
        with path.open("rb") as stream:
            yield name, stream


def _useless(upload: Upload, listed: list[Rejection], count: int) -> InvalidInput:
    what = {SurveyFormat.TRACES: "files", SurveyFormat.JSON: "fingerprints"}.get(upload.format, "")
    if not listed:
        return InvalidInput("the survey holds no fingerprint", what)
    reasons = "; ".join(f"{one.item}: {one.reason}" for one in listed[:REASONS_SHOWN])
    more = f"; and {count - REASONS_SHOWN} more" if count > REASONS_SHOWN else ""
    item = listed[0].item
    field_name = what if what == "files" else f"row {item}" if isinstance(item, int) else str(item)
    return UselessSurvey(f"nothing of the survey can be used: {reasons}{more}", field_name, tuple(listed), count)
