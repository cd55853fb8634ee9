"""Surveys as recorded walks, many files at once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import IO

from app.errors import InvalidInput
from app.survey.admission import FloorExtent, SurveyNotes, checked_place
from app.survey.placement import fingerprints_of
from app.survey.trace import Trace, read_traces
from app.survey.unpacking import Allowance
from app.wifi.fingerprint import Fingerprint

LONGEST_WALK = 200
"""Characters of a walk's id."""


def read_walks(
    files: Iterable[tuple[str, IO[bytes]]], extent: FloorExtent, notes: SurveyNotes
) -> Iterator[Fingerprint]:
    """Fingerprints along the walks of one floor, walk by walk.

    Files that are no traces, walks without waypoints, records that cannot be read and scans outside the floor are
    rejected; the rest lands. Of walks with the same id (file name up to its first dot) the first counts.
    """
    allowance, walks = Allowance(), set[str]()
    for name, stream in files:
        try:
            for trace in read_traces(stream, name, allowance):
                fault = _fault_of_name(trace.trace, walks)
                if fault:
                    notes.rejections.add(name, fault)
                    continue
                walks.add(trace.trace)
                yield from _placed(trace, extent, notes)
        except InvalidInput as error:
            notes.rejections.add(name, str(error))


def _fault_of_name(walk: str, earlier: set[str]) -> str:
    if walk in earlier:
        return f"a second walk called {walk[:80]!r}: give each file a name of its own"
    if not walk or len(walk) > LONGEST_WALK or not walk.isprintable():
        return f"the file name up to its first dot names the walk: 1 to {LONGEST_WALK} printable characters"
    return ""


def _placed(trace: Trace, extent: FloorExtent, notes: SurveyNotes) -> Iterator[Fingerprint]:
    notes.rejections.extend(trace.rejected, trace.rejected_count)
    fingerprints, rejected = fingerprints_of(trace, extent.floor)
    notes.rejections.extend(rejected)
    for fingerprint in fingerprints:
        try:
            checked_place(fingerprint.x_m, fingerprint.y_m, extent)
        except ValueError as error:
            notes.rejections.add(f"{trace.trace} at {round(fingerprint.time_s * 1000)}", str(error))
        else:
            yield fingerprint
    if not notes.device and (trace.device.brand or trace.device.model):
        notes.device = {"brand": trace.device.brand, "model": trace.device.model}
