"""Who is in a venue: its live phones with their newest fixes, for those who run the venue.

A session id is a capability: who knows it may read and erase that phone's track. So a listing names phones by a number
from which the id cannot be had.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import orjson

from app.errors import NotFound
from app.storage.phone_rows import PhoneRows

LIVE_S = 60.0
"""A phone that has been silent for longer is not listed."""


@dataclass(frozen=True, slots=True)
class NewestFix:
    """A session's newest fix. received_s : server's clock, Unix.  fix : the body of the Fix as it was answered."""

    session: str
    received_s: float
    fix: Mapping[str, Any]


class FixReader(Protocol):
    """What storage offers for it."""

    async def newest_fixes(self, venue: str, since_s: float) -> Sequence[NewestFix]:
        """The newest fix of every session of a venue that is not over, received since then (server's clock).

        Raises
        ------
        NotFound : there is no such venue.
        """
        ...


class StoredFixes:
    """The FixReader over the database."""

    def __init__(self, rows: PhoneRows) -> None:
        self._rows = rows

    async def newest_fixes(self, venue: str, since_s: float) -> Sequence[NewestFix]:
        """As FixReader says. Raises DependencyDown too, where the database cannot be reached."""
        rows = await self._rows.newest(venue, round(1000.0 * since_s))
        if rows is None:
            raise NotFound(f"there is no venue {venue[:64]!r}")
        return [NewestFix(row.session, row.received_ms / 1000.0, orjson.loads(row.body)) for row in rows]


def public_number(session: str) -> str:
    """A short name for a session, the same every time, that does not lead back to it."""
    return hashlib.sha256(f"phone {session}".encode()).hexdigest()[:6]


async def live_phones(reader: FixReader, venue: str, now_s: float) -> list[dict[str, Any]]:
    """The phones heard of within LIVE_S, as `{"phone", "age", "fix"}` (age in seconds), in order of their numbers.

    Raises
    ------
    NotFound : there is no such venue.
    """
    newest = await reader.newest_fixes(venue, now_s - LIVE_S)
    phones = [
        {
            "phone": public_number(one.session),
            "age": max(now_s - one.received_s, 0.0),
            "fix": {name: value for name, value in one.fix.items() if name != "session"},
        }
        for one in newest
    ]
    return sorted(phones, key=lambda phone: str(phone["phone"]))
