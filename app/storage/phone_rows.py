"""The phones that are in a venue, from the newest fixes of its sessions."""

from __future__ import annotations

from dataclasses import dataclass

from sqlalchemy import and_, bindparam, select
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import reachable
from app.storage.tables import fixes, sessions, venues


@dataclass(frozen=True, slots=True)
class PhoneRow:
    """A session's newest fix. received_ms : server's clock, Unix.  body : the Fix as it was answered."""

    session: str
    received_ms: int
    body: bytes


class PhoneRows:
    """Reads newest fixes.

    Parameters
    ----------
    session_hours : the setting. A session expires so long after its last batch, which tells when that came.
    """

    def __init__(self, engine: AsyncEngine, session_hours: float) -> None:
        self._engine = engine
        self._lifetime_ms = round(session_hours * 3_600_000)

    async def newest(self, venue: str, since_ms: int) -> list[PhoneRow] | None:
        """The newest fix of every session of a venue, received since then; None if there is no such venue.

        Raises
        ------
        DependencyDown : the database cannot be reached.
        """
        async with reachable(), self._engine.connect() as connection:
            venue_id = await connection.scalar(select(venues.c.id).where(venues.c.venue == venue))
            if venue_id is None:
                return None
            found = await connection.execute(_READ, {"of": venue_id, "since": since_ms + self._lifetime_ms})
            return [PhoneRow(row.session, row.expires_ms - self._lifetime_ms, row.body) for row in found]


_READ = (
    select(sessions.c.session, sessions.c.expires_ms, fixes.c.body)
    .join(fixes, and_(fixes.c.session == sessions.c.session, fixes.c.sequence == sessions.c.sequence))
    .where(sessions.c.venue_id == bindparam("of"), sessions.c.expires_ms >= bindparam("since"))
)
