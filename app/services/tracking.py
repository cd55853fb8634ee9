"""Sessions of phones: opened, advanced batch by batch, erased.

A batch costs one read, the method's own work, and one transaction that stores the Fix together with the state behind
it. So a process that dies between two batches loses nothing, and any worker can take the next one.
"""

from __future__ import annotations

import asyncio
import dataclasses
import re
import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakValueDictionary

from app.errors import Conflict, Expired, InvalidInput, NotFound
from app.fusion.evidence_codec import encode_evidence
from app.fusion.interface import Method, SessionStart, Site
from app.fusion.state_codec import decode_state, encode_state
from app.observations import Batch, Fix
from app.services.alerts import alert_of
from app.services.announcements import ALERTS, Announcements
from app.services.fix_document import fix_document, initial_document
from app.services.fix_listener import FixListener
from app.services.identifiers import is_identifier, no_venue
from app.services.session_clock import refuse_out_of_window
from app.services.site_cache import SiteCache, refuse_off_floor, refuse_unknown_floor
from app.services.smoothed_tracks import SmoothedTracks
from app.services.tickets import check_ticket, issue_ticket
from app.storage.session_rows import FixRow, SessionRow, SessionRows
from app.storage.session_state import HotStates

ATTEMPTS = 5
"""How often a batch is tried anew when another worker was faster."""
LONG_BATCH = 5_000
"""Samples and readings from which a batch is worked on beside the event loop."""
FORGET_AFTER_MS = 30 * 86_400_000
"""An expired session is remembered so long, to be told from an unknown one."""
_SESSION = re.compile(r"[0-9a-f]{32}")


@dataclass(frozen=True, slots=True)
class Answer:
    """A Fix as sent. replayed : it was stored before."""

    body: bytes
    replayed: bool


@dataclass(frozen=True, slots=True)
class OpenedSession:
    """A new session. Times are Unix ms of the server's clock."""

    session: str
    venue: str
    method: str
    created_ms: int
    expires_ms: int


class Tracking:
    """What phones may do.

    Every method raises NotFound for an unknown session, Expired for one that is over, and DependencyDown, having
    changed nothing, where a store cannot be reached.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(
        self,
        rows: SessionRows,
        hot: HotStates,
        sites: SiteCache,
        methods: Mapping[str, Method],
        session_hours: float,
        now_ms: Callable[[], int],
        listeners: Sequence[FixListener] = (),
    ) -> None:
        self._rows = rows
        self._hot = hot
        self._sites = sites
        self._methods = methods
        self._lifetime_ms = round(session_hours * 3_600_000)
        self._now_ms = now_ms
        self._listeners = listeners
        self._locks: WeakValueDictionary[str, asyncio.Lock] = WeakValueDictionary()
        self.announcements = Announcements()
        self.smoothed = SmoothedTracks(rows, sites, self.live, methods)

    async def open(
        self, venue: str, method: str, start: SessionStart, device: Mapping[str, str] | None = None
    ) -> OpenedSession:
        """A new session.

        Raises
        ------
        NotFound : no such venue, or floor of it; a floor with its field.
        InvalidInput : no such method, or a start that is not on its floor.
        """
        if method not in self._methods:
            raise InvalidInput(f"method is one of {', '.join(sorted(self._methods))}", "method")
        found = await self._rows.venue(venue) if is_identifier(venue) else None
        if found is None:
            raise no_venue(venue)
        venue_id, revision = found
        site = await self._sites.site(venue, revision)
        refuse_unknown_floor(site, start.floor, "floor")
        refuse_off_floor(site, start.start)
        now_ms = self._now_ms()
        opened = OpenedSession(secrets.token_hex(16), venue, method, now_ms, now_ms + self._lifetime_ms)
        await self._rows.open(
            {
                "session": opened.session,
                "venue_id": venue_id,
                "method": method,
                "alert_limit_m": start.alert_limit_m,
                "risk": start.risk,
                "floor_hint": start.floor,
                "start": None if start.start is None else dataclasses.asdict(start.start),
                "device": None if device is None else dict(device),
                "created_ms": opened.created_ms,
                "expires_ms": opened.expires_ms,
                "sequence": -1,
                "state": encode_state(self._methods[method].start(start)),
                "ticket_key": secrets.token_bytes(16),
            }
        )
        return opened

    async def advance(self, session: str, batch: Batch) -> Answer:
        """The Fix that a batch leads to; a batch sent again gets the Fix it got.

        Raises
        ------
        Conflict : the batch is older than the newest.
        InvalidInput : its times do not follow on the session's.
        """
        lock = self._locks.setdefault(session, asyncio.Lock())
        async with lock:
            for _ in range(ATTEMPTS):
                row = await self.live(session)
                if batch.sequence <= row.sequence:
                    return await self._replay(row, batch)
                body = await self._move(row, batch)
                if body is not None:
                    return Answer(body, replayed=False)
        raise Conflict("other batches of this session keep arriving at the same time; send one after the other")

    async def _replay(self, row: SessionRow, batch: Batch) -> Answer:
        stored = await self._rows.read_fix(row.session, row.sequence) if batch.sequence == row.sequence else None
        if stored is None:
            raise Conflict(f"batch {batch.sequence} is older than the newest, {row.sequence}")
        return Answer(stored.body, replayed=True)

    async def _move(self, row: SessionRow, batch: Batch) -> bytes | None:
        """Advance from the state that the row names and store the outcome; None if another worker was faster."""
        refuse_out_of_window(batch, None if row.newest_ms is None else row.newest_ms / 1000.0)
        batch = dataclasses.replace(batch, gap=batch.sequence != row.sequence + 1)
        site = await self._sites.site(row.venue, row.revision)
        state = await self._hot.get(row.session, row.sequence)
        if state is None:
            stored = await self._rows.read_state(row.session, row.sequence)
            if not stored:
                return None
            state = decode_state(stored)
        state, fix = await self._advanced(row.method, state, batch, site)
        encoded = encode_state(state)
        made = FixRow(
            batch.sequence,
            None if fix.time_s is None else round(1000.0 * fix.time_s),
            fix_document(row.session, batch, fix, site),
            encode_evidence(fix),
        )
        now_ms = self._now_ms()
        alert = alert_of(row, made, now_ms)
        if not await self._rows.add_fix(row.session, row.sequence, made, encoded, now_ms + self._lifetime_ms, alert):
            return None
        await self._hot.put(row.session, batch.sequence, state, encoded)
        self.announcements.announce(row.session, batch.sequence)
        if alert is not None:
            self.announcements.announce(ALERTS)
        for heard in self._listeners:
            await heard(row.venue, site, row.session, row.method, fix)
        return made.body

    async def _advanced(self, method: str, state: Any, batch: Batch, site: Site) -> tuple[Any, Fix]:
        advance = self._methods[method].advance
        if batch.size < LONG_BATCH:
            return advance(state, batch, site)
        return await asyncio.to_thread(advance, state, batch, site)

    async def live(self, session: str) -> SessionRow:
        """The session, unless it is over."""
        row = await self._rows.read(session) if _SESSION.fullmatch(session) else None
        if row is None:
            raise NotFound("there is no such session")
        if row.expires_ms < self._now_ms():
            raise Expired("the session is over; open a new one")
        return row

    async def newest_fix(self, session: str) -> bytes:
        """The newest Fix; before the first batch one of sequence -1 that knows nothing."""
        row = await self.live(session)
        stored = await self._rows.read_fix(session, row.sequence)
        return initial_document(session, row.alert_limit_m, row.risk) if stored is None else stored.body

    async def track(
        self, session: str, after: int, limit: int, from_ms: int | None = None, to_ms: int | None = None
    ) -> list[FixRow]:
        """Fixes after a sequence, in order, at most limit, with `t` within the bounds."""
        await self.live(session)
        return await self._rows.read_track(session, after, limit, from_ms, to_ms)

    async def ticket(self, session: str) -> tuple[str, int]:
        """A ticket to the session's events, and when it expires, Unix ms."""
        return issue_ticket((await self.live(session)).ticket_key, self._now_ms())

    async def admit(self, session: str, ticket: str) -> None:
        """Nothing, if the ticket is this session's and still good.

        Raises
        ------
        Unauthenticated : it is not.
        """
        check_ticket(ticket, (await self.live(session)).ticket_key, self._now_ms())

    async def erase(self, session: str) -> None:
        """Remove the session, its track and its state."""
        if not _SESSION.fullmatch(session):
            raise NotFound("there is no such session")
        async with self._locks.setdefault(session, asyncio.Lock()):
            await self._hot.discard(session)
            if not await self._rows.erase(session):
                raise NotFound("there is no such session")
        self.announcements.announce(session)

    async def purge(self) -> int:
        """Erase the tracks and states of sessions that are over; gives their number."""
        now_ms = self._now_ms()
        return await self._rows.purge(now_ms, now_ms - FORGET_AFTER_MS)
