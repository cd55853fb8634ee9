"""Sessions and their fixes in the database: the durable truth of every session."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, and_, bindparam, delete, insert, select, update
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import LONG_S, reachable
from app.storage.outbox_rows import Alert, post_alert
from app.storage.tables import fixes, sessions, venues


@dataclass(frozen=True, slots=True)
class SessionRow:
    """A session without its state.

    revision : of the venue, rises with everything that changes its Site.  sequence : of the newest batch, -1 before
    there is one.  newest_ms : the phone's time that its Fix accounts for.  newest_body : that Fix as answered.
    Times are Unix ms.
    """

    session: str
    venue: str
    revision: int
    method: str
    alert_limit_m: float
    risk: float
    expires_ms: int
    sequence: int
    newest_ms: int | None
    ticket_key: bytes
    newest_body: bytes | None


@dataclass(frozen=True, slots=True)
class FixRow:
    """A stored Fix: its body is the answer, byte for byte. evidence : what it was made of; written, not read back."""

    sequence: int
    t_ms: int | None
    body: bytes
    evidence: bytes | None = None


@dataclass(frozen=True, slots=True)
class EvidenceRow:
    """What a stored Fix was made of; None of one that an early version stored."""

    sequence: int
    t_ms: int | None
    evidence: bytes | None


class SessionRows:
    """Reads and writes sessions; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def venue(self, venue: str) -> tuple[int, int] | None:
        """A venue's key and revision; None if there is none."""
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(_READ_VENUE, {"named": venue})).one_or_none()
        return None if row is None else (row.id, row.revision)

    async def open(self, row: Mapping[str, Any]) -> None:
        """Insert a session that has no batch yet (sequence -1)."""
        async with reachable(), self._engine.begin() as connection:
            await connection.execute(_INSERT_SESSION, dict(row))

    async def read(self, session: str) -> SessionRow | None:
        """The session, with what its venue and newest Fix say; None if there is none."""
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(_READ, {"session": session})).one_or_none()
        return None if row is None else SessionRow(*row)

    async def read_state(self, session: str, sequence: int) -> bytes | None:
        """The encoded state after that batch; None if the session has moved on."""
        async with reachable(), self._engine.connect() as connection:
            state: bytes | None = await connection.scalar(_READ_STATE, {"session": session, "sequence": sequence})
        return state

    async def add_fix(
        self, session: str, after: int, fix: FixRow, state: bytes, expires_ms: int, alert: Alert | None = None
    ) -> bool:
        """Store a Fix, the state behind it and the alert that it raises or clears: all or nothing.

        Parameters
        ----------
        after : the sequence that the state was advanced from.  alert : to be sent to the venue's webhooks.

        Returns
        -------
        False if the session is no longer there: another worker was faster, or the session is gone. Nothing is changed.
        """
        moved = {"of": session, "after": after, "to": fix.sequence, "blob": state, "until": expires_ms}
        made = {"session": session, "sequence": fix.sequence, "t_ms": fix.t_ms, "body": fix.body}
        made["evidence"] = fix.evidence
        async with reachable(), self._engine.begin() as connection:
            if (await connection.execute(_MOVE, moved)).rowcount != 1:
                return False
            await connection.execute(_INSERT_FIX, made)
            if alert is not None:
                await post_alert(connection, session, alert)
        return True

    async def read_fix(self, session: str, sequence: int) -> FixRow | None:
        """One stored Fix."""
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(_READ_FIX, {"of": session, "at": sequence})).one_or_none()
        return None if row is None else FixRow(*row)

    async def read_track(
        self, session: str, after: int, limit: int, from_ms: int | None = None, to_ms: int | None = None
    ) -> list[FixRow]:
        """Stored fixes in order of sequence.

        Parameters
        ----------
        after : sequence below the first; -1 for the beginning.  from_ms, to_ms : bounds of `t`, both included.
        """
        query = select(fixes.c.sequence, fixes.c.t_ms, fixes.c.body).where(
            fixes.c.session == session, fixes.c.sequence > after
        )
        if from_ms is not None:
            query = query.where(fixes.c.t_ms >= from_ms)
        if to_ms is not None:
            query = query.where(fixes.c.t_ms <= to_ms)
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(query.order_by(fixes.c.sequence).limit(limit))).all()
        return [FixRow(*row) for row in rows]

    async def read_evidence(self, session: str) -> list[EvidenceRow]:
        """What all fixes of a session were made of, in order of sequence."""
        query = select(fixes.c.sequence, fixes.c.t_ms, fixes.c.evidence).where(fixes.c.session == session)
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(query.order_by(fixes.c.sequence))).all()
        return [EvidenceRow(*row) for row in rows]

    async def sequences(self, wanted: Sequence[str], now_ms: int) -> dict[str, int]:
        """The newest sequence of each of these sessions that is not over."""
        found: dict[str, int] = {}
        async with reachable(), self._engine.connect() as connection:
            for begin in range(0, len(wanted), _AT_ONCE):
                some = {"wanted": wanted[begin : begin + _AT_ONCE], "now_ms": now_ms}
                rows = await connection.execute(_READ_SEQUENCES, some)
                found.update((row.session, row.sequence) for row in rows)
        return found

    async def erase(self, session: str) -> bool:
        """Remove a session with everything it has left; False if there is none."""
        async with reachable(LONG_S), self._engine.begin() as connection:
            await connection.execute(delete(fixes).where(fixes.c.session == session))
            return (await connection.execute(delete(sessions).where(sessions.c.session == session))).rowcount == 1

    async def purge(self, now_ms: int, forget_before_ms: int) -> int:
        """Erase what sessions over by now have left, but for the row that says they existed, and those rows in the end.

        Parameters
        ----------
        forget_before_ms : sessions over by then are forgotten altogether.

        Returns
        -------
        How many sessions were emptied.
        """
        over = select(sessions.c.session).where(sessions.c.expires_ms < now_ms)
        async with reachable(LONG_S), self._engine.begin() as connection:
            await connection.execute(delete(fixes).where(fixes.c.session.in_(over)))
            emptied = await connection.execute(
                update(sessions)
                .where(sessions.c.expires_ms < now_ms, sessions.c.state != b"")
                .values(state=b"", start=None, device=None, floor_hint=None, ticket_key=b"")
            )
            await connection.execute(delete(sessions).where(sessions.c.expires_ms < forget_before_ms))
        return emptied.rowcount


_AT_ONCE = 1000
"""Sessions asked for in one statement."""
_INSERT_SESSION = insert(sessions)
_INSERT_FIX = insert(fixes)
_READ_VENUE = select(venues.c.id, venues.c.revision).where(venues.c.venue == bindparam("named"))
_READ: Select[Any] = (
    select(
        sessions.c.session,
        venues.c.venue,
        venues.c.revision,
        sessions.c.method,
        sessions.c.alert_limit_m,
        sessions.c.risk,
        sessions.c.expires_ms,
        sessions.c.sequence,
        fixes.c.t_ms,
        sessions.c.ticket_key,
        fixes.c.body,
    )
    .join(venues, venues.c.id == sessions.c.venue_id)
    .outerjoin(fixes, and_(fixes.c.session == sessions.c.session, fixes.c.sequence == sessions.c.sequence))
    .where(sessions.c.session == bindparam("session"))
)
_READ_STATE = select(sessions.c.state).where(
    sessions.c.session == bindparam("session"), sessions.c.sequence == bindparam("sequence")
)
_READ_FIX = select(fixes.c.sequence, fixes.c.t_ms, fixes.c.body).where(
    fixes.c.session == bindparam("of"), fixes.c.sequence == bindparam("at")
)
_READ_SEQUENCES = select(sessions.c.session, sessions.c.sequence).where(
    sessions.c.session.in_(bindparam("wanted", expanding=True)), sessions.c.expires_ms >= bindparam("now_ms")
)
_MOVE = (
    update(sessions)
    .where(sessions.c.session == bindparam("of"), sessions.c.sequence == bindparam("after"))
    .values(sequence=bindparam("to"), state=bindparam("blob"), expires_ms=bindparam("until"))
)
