"""What happens in a session, as it happens: every Fix, and an alert when the flag enters `fault` and when it leaves."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from dataclasses import dataclass

import orjson

from app.errors import Expired, NotFound
from app.services.fix_document import in_fault
from app.services.tracking import Tracking
from app.storage.session_rows import FixRow

KEEP_ALIVE_S = 15.0
PAGE = 200


@dataclass(frozen=True, slots=True)
class SessionEvent:
    """One event. name : fix, alert or end.  sequence : of the Fix.  data : JSON."""

    name: str
    sequence: int
    data: bytes


async def follow(tracking: Tracking, session: str, after: int | None) -> AsyncIterator[SessionEvent | None]:
    """Events after a sequence, or from the newest Fix on; None now and then, while nothing happens.

    An alert comes before its Fix: who resumes after the last Fix that arrived has missed no alert. Ends, after an event
    `end`, when the session is over or erased.
    """
    with tracking.announcements.listen(session) as announced:
        at, alerted = await _begin(tracking, session, after)
        while True:
            announced.clear()
            try:
                rows = await tracking.track(session, at, PAGE)
            except (NotFound, Expired) as over:
                yield SessionEvent("end", at, orjson.dumps({"session": session, "reason": str(over)}))
                return
            for row in rows:
                at = row.sequence
                if in_fault(row.body) != alerted:
                    alerted = not alerted
                    yield _alert(session, row, alerted)
                yield SessionEvent("fix", row.sequence, row.body)
            while len(rows) < PAGE and not announced.is_set():
                try:
                    await asyncio.wait_for(announced.wait(), KEEP_ALIVE_S)
                except TimeoutError:
                    yield None


async def _begin(tracking: Tracking, session: str, after: int | None) -> tuple[int, bool]:
    """The sequence to begin after, and whether the session was in fault there."""
    newest = (await tracking.live(session)).sequence
    if after is None:
        return newest - 1, False
    after = min(after, newest)
    before = await tracking.track(session, after - 1, 1)
    return after, bool(before) and before[0].sequence == after and in_fault(before[0].body)


def _alert(session: str, row: FixRow, raised: bool) -> SessionEvent:
    fix = orjson.loads(row.body)
    alert = {
        "session": session,
        "sequence": row.sequence,
        "t": fix["t"],
        "alert": "raised" if raised else "cleared",
        "flag": fix["integrity"]["flag"],
        "excluded": fix["integrity"]["excluded"],
    }
    return SessionEvent("alert", row.sequence, orjson.dumps(alert))
