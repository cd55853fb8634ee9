"""Watch lists of radio-map versions in the database, and the sessions whose exclusions lead to them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Select, and_, delete, func, insert, select, update
from sqlalchemy.ext.asyncio import AsyncConnection, AsyncEngine

from app.storage.database import reachable
from app.storage.radio_map_rows import lock_venue, of_version
from app.storage.tables import radio_maps, venues, watch_confirmations, watch_evidence, watched_access_points
from app.storage.upsert import upsert

_LIST, _TOLD = watched_access_points, watch_confirmations
HOUR_MS = 3_600_000


@dataclass(frozen=True, slots=True)
class WatchedRow:
    """An access point on a watch list. evidence : sessions that have excluded it.  removed_ms : by an administrator,
    None while it is watched.  Times are Unix ms of the server's clock."""

    bssid: int
    reason: str
    first_seen_ms: int
    last_seen_ms: int
    evidence: int
    removed_ms: int | None


class WatchListRows:
    """Reads and writes watch lists; every method is one transaction.

    Each raises DependencyDown where the database cannot be reached, having changed nothing. What changes which access
    points are watched raises the venue's revision.
    """

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def listed(self, venue: str, version: int) -> list[WatchedRow] | None:
        """Everything on a version's list, removed ones too, newest first; None if there is no such version."""
        async with reachable(), self._engine.connect() as connection:
            found = await _version(connection, venue, version)
            if found is None:
                return None
            query = _ROWS.where(_LIST.c.radio_map_id == found[1])
            rows = await connection.execute(query.order_by(_LIST.c.first_seen_ms.desc(), _LIST.c.bssid))
            return [WatchedRow(*row) for row in rows]

    async def watched(self, venue: str, version: int) -> frozenset[int]:
        """The access points that are to be left out with a version; empty also where there is no such version."""
        query = of_version(venue, version, _LIST.c.bssid).join(_LIST, _LIST.c.radio_map_id == radio_maps.c.id)
        query = query.where(_LIST.c.removed_ms.is_(None))
        async with reachable(), self._engine.connect() as connection:
            return frozenset((await connection.scalars(query)).all())

    async def add(
        self, venue: str, version: int, bssid: int, reason: str, now_ms: int
    ) -> tuple[WatchedRow, bool] | None:
        """Put an access point on a list; one that is watched already stays as it is.

        Returns
        -------
        Its row, and whether it was put there now; None if there is no such version.
        """
        async with reachable(), self._engine.begin() as connection:
            found = await _locked(connection, venue, version)
            if found is None:
                return None
            venue_id, map_id = found
            row = await _row(connection, map_id, bssid)
            if row is not None and row.removed_ms is None:
                return row, False
            values = {"reason": reason, "first_seen_ms": now_ms, "last_seen_ms": now_ms, "removed_ms": None}
            await _put(connection, map_id, bssid, values, new=row is None)
            await _raise_revision(connection, venue_id)
            made = await _row(connection, map_id, bssid)
        assert made is not None  # put there in this transaction
        return made, True

    async def remove(self, venue: str, version: int, bssid: int, now_ms: int) -> bool:
        """Watch an access point no longer, whatever sessions say; False if it is not watched."""
        async with reachable(), self._engine.begin() as connection:
            found = await _locked(connection, venue, version)
            if found is None:
                return False
            venue_id, map_id = found
            here = _LIST.c.radio_map_id == map_id, _LIST.c.bssid == bssid, _LIST.c.removed_ms.is_(None)
            removed = await connection.execute(update(_LIST).where(*here).values(removed_ms=now_ms))
            if removed.rowcount != 1:
                return False
            await _raise_revision(connection, venue_id)
        return True

    async def notice(
        self,
        venue: str,
        version: int,
        session_digest: bytes,
        reasons: Mapping[int, str],
        now_ms: int,
        since_ms: int,
        needed: int,
        share: float,
    ) -> frozenset[int]:
        """Note that a session has excluded access points; list those that enough sessions have excluded.

        The same session counts once for each, however often and on however many workers it is noticed.

        Parameters
        ----------
        reasons : by bssid.  since_ms : sessions noticed before count no more.  needed : sessions it takes.
        share : of those that exclude it and those that confirm it together which it takes.

        Returns
        -------
        What has come onto the list by this.
        """
        listed: set[int] = set()
        async with reachable(), self._engine.begin() as connection:
            found = await _locked(connection, venue, version)
            if found is None:  # the venue is gone; its sessions will be
                return frozenset()
            venue_id, map_id = found
            for bssid, reason in sorted(reasons.items()):
                if not await _note(connection, map_id, bssid, session_digest, now_ms, since_ms):
                    continue
                row = await _row(connection, map_id, bssid)
                if row is not None:
                    seen = {"last_seen_ms": now_ms, "evidence": row.evidence + 1}
                    await _put(connection, map_id, bssid, seen, new=False)
                    continue
                first_ms, count = await _evidence(connection, map_id, bssid, since_ms)
                confirming = await _confirming(connection, map_id, bssid, since_ms)
                if count >= max(needed, share * (count + confirming)):
                    values = {"reason": reason, "first_seen_ms": first_ms, "last_seen_ms": now_ms, "evidence": count}
                    await _put(connection, map_id, bssid, values, new=True)
                    listed.add(bssid)
            if listed:
                await _raise_revision(connection, venue_id)
        return frozenset(listed)

    async def confirm(self, venue: str, version: int, sessions: Mapping[int, int], now_ms: int) -> None:
        """Note that sessions have heard access points as they were surveyed. sessions : how many, by bssid."""
        async with reachable(), self._engine.begin() as connection:
            found = await _locked(connection, venue, version)
            if found is None or not sessions:
                return
            adding = upsert(
                connection,
                _TOLD,
                ("radio_map_id", "bssid", "hour"),
                lambda excluded: {"sessions": _TOLD.c.sessions + excluded.sessions},
            )
            here = {"radio_map_id": found[1], "hour": now_ms // HOUR_MS}
            rows = [here | {"bssid": bssid, "sessions": count} for bssid, count in sessions.items()]
            await connection.execute(adding, rows)

    async def forget_evidence(self, before_ms: int) -> None:
        """Drop what sessions said before a time."""
        async with reachable(), self._engine.begin() as connection:
            await connection.execute(delete(watch_evidence).where(watch_evidence.c.seen_ms < before_ms))
            await connection.execute(delete(_TOLD).where(_TOLD.c.hour < before_ms // HOUR_MS))


async def _version(connection: AsyncConnection, venue: str, version: int) -> tuple[int, int] | None:
    """The keys of a venue and of its version."""
    row = (await connection.execute(of_version(venue, version, venues.c.id, radio_maps.c.id))).one_or_none()
    return None if row is None else (row[0], row[1])


async def _locked(connection: AsyncConnection, venue: str, version: int) -> tuple[int, int] | None:
    """The same, with every other writer of the venue made to wait: what is read after this cannot change."""
    found = await _version(connection, venue, version)
    if found is not None:
        await lock_venue(connection, found[0])
    return found


async def _row(connection: AsyncConnection, map_id: int, bssid: int) -> WatchedRow | None:
    query = _ROWS.where(_LIST.c.radio_map_id == map_id, _LIST.c.bssid == bssid)
    row = (await connection.execute(query)).one_or_none()
    return None if row is None else WatchedRow(*row)


async def _put(connection: AsyncConnection, map_id: int, bssid: int, values: Mapping[str, Any], new: bool) -> None:
    if new:
        row = {"radio_map_id": map_id, "bssid": bssid, "evidence": 0, **values}
        await connection.execute(insert(_LIST).values(row))
        return
    here = _LIST.c.radio_map_id == map_id, _LIST.c.bssid == bssid
    await connection.execute(update(_LIST).where(*here).values(dict(values)))


async def _note(
    connection: AsyncConnection, map_id: int, bssid: int, session_digest: bytes, now_ms: int, since_ms: int
) -> bool:
    """Whether a session says something new of an access point; it is written down."""
    here = and_(
        watch_evidence.c.radio_map_id == map_id,
        watch_evidence.c.bssid == bssid,
        watch_evidence.c.session_digest == session_digest,
    )
    seen_ms = await connection.scalar(select(watch_evidence.c.seen_ms).where(here))
    if seen_ms is not None and seen_ms >= since_ms:
        return False
    if seen_ms is not None:
        await connection.execute(update(watch_evidence).where(here).values(seen_ms=now_ms))
        return True
    row = {"radio_map_id": map_id, "bssid": bssid, "session_digest": session_digest, "seen_ms": now_ms}
    await connection.execute(insert(watch_evidence).values(row))
    return True


async def _evidence(connection: AsyncConnection, map_id: int, bssid: int, since_ms: int) -> tuple[int, int]:
    """When the first of the sessions that still count said so, and how many they are."""
    here = (
        watch_evidence.c.radio_map_id == map_id,
        watch_evidence.c.bssid == bssid,
        watch_evidence.c.seen_ms >= since_ms,
    )
    row = (await connection.execute(select(func.min(watch_evidence.c.seen_ms), func.count()).where(*here))).one()
    return int(row[0]), int(row[1])


async def _confirming(connection: AsyncConnection, map_id: int, bssid: int, since_ms: int) -> int:
    """How many sessions have confirmed it since the hour of that time."""
    here = _TOLD.c.radio_map_id == map_id, _TOLD.c.bssid == bssid, _TOLD.c.hour >= since_ms // HOUR_MS
    return int(await connection.scalar(select(func.coalesce(func.sum(_TOLD.c.sessions), 0)).where(*here)) or 0)


async def _raise_revision(connection: AsyncConnection, venue_id: int) -> None:
    await connection.execute(update(venues).where(venues.c.id == venue_id).values(revision=venues.c.revision + 1))


_ROWS: Select[Any] = select(
    _LIST.c.bssid, _LIST.c.reason, _LIST.c.first_seen_ms, _LIST.c.last_seen_ms, _LIST.c.evidence, _LIST.c.removed_ms
)
