"""When a session's flag enters `fault` and when it leaves: what is told to those who run the venue."""

from __future__ import annotations

import hashlib

import orjson

from app.services.fix_document import in_fault
from app.services.phones import public_number
from app.storage.outbox_rows import Alert
from app.storage.session_rows import FixRow, SessionRow


def alert_of(before: SessionRow, made: FixRow, now_ms: int) -> Alert | None:
    """The alert that a new Fix of a session raises or clears; None where it does neither.

    Names the phone as listings do and gives no coordinates: whoever receives it may not read the phone's track, a
    position in fault is not to be trusted, and an alert that waits may outlive its session's erasure.
    """
    fault = in_fault(made.body)
    if fault == in_fault(before.newest_body):
        return None
    fix = orjson.loads(made.body)
    event = hashlib.sha256(f"alert {before.session} {made.sequence}".encode()).hexdigest()[:32]
    position = fix["position"]
    body = {
        "event": event,
        "type": "alert.raised" if fault else "alert.cleared",
        "created": now_ms,
        "venue": before.venue,
        "phone": public_number(before.session),
        "sequence": made.sequence,
        "t": fix["t"],
        "flag": fix["integrity"]["flag"],
        "floor": None if position is None else position["floor"],
        "excluded": fix["integrity"]["excluded"],
    }
    return Alert(event, orjson.dumps(body), now_ms)
