"""Who is in a venue: its live phones with their newest fixes, for those who run the venue.

A session id is a capability: who knows it may read and erase that phone's track. So a listing names phones by a number
from which the id cannot be had.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any

import orjson

from app.services.identifiers import is_identifier, no_venue
from app.storage.phone_rows import PhoneRow, PhoneRows

LIVE_MS = 60_000
"""A phone that has been silent for longer is not listed."""


class Phones:
    """Lists phones.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(self, rows: PhoneRows, now_ms: Callable[[], int]) -> None:
        self._rows = rows
        self._now_ms = now_ms

    async def live(self, venue: str) -> list[dict[str, Any]]:
        """The phones heard of within LIVE_MS, as `{"phone", "age", "fix"}` (age in seconds), in order of their numbers.

        Raises
        ------
        NotFound : there is no such venue.
        DependencyDown : the database cannot be reached.
        """
        now_ms = self._now_ms()
        rows = await self._rows.newest(venue, now_ms - LIVE_MS) if is_identifier(venue) else None
        if rows is None:
            raise no_venue(venue)
        return sorted((_phone(row, now_ms) for row in rows), key=lambda phone: str(phone["phone"]))


def public_number(session: str) -> str:
    """A short name for a session, the same every time, that does not lead back to it."""
    return hashlib.sha256(f"phone {session}".encode()).hexdigest()[:6]


def _phone(row: PhoneRow, now_ms: int) -> dict[str, Any]:
    fix = orjson.loads(row.body)
    del fix["session"]
    return {"phone": public_number(row.session), "age": max(now_ms - row.received_ms, 0) / 1000.0, "fix": fix}
