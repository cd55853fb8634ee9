"""Watch lists: access points that a radio-map version can no longer rely on.

Sessions report what they exclude and why, and what they hear as it was surveyed. What enough of them exclude, and not
too many confirm, is left out of every session of the venue, for good until a new version is surveyed, unless an
administrator takes it off the list.

That a few exclude it is not enough: of thousands of visitors a day some exclude any access point by mistake.
"""

from __future__ import annotations

import hashlib
import logging
from collections import Counter, OrderedDict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from enum import StrEnum

from app.errors import DependencyDown, InvalidInput, NotFound
from app.fusion.interface import Site
from app.integrity.access_point_record import AccessPointFault
from app.observations import Excluded, Fix
from app.services.identifiers import is_identifier, no_version
from app.storage.watch_list_rows import WatchedRow, WatchListRows
from app.wifi.bssid import parse_bssid

REASONS = frozenset(AccessPointFault)
"""First words of the reasons that say something about an access point, and not about a phone or a moment."""
WATCHED_MS = 48 * 3_600_000
"""For so long after it was first seen an access point is watched; then it is permanently left out."""
REMEMBERED = 10_000
"""Sessions of which this process remembers what it has written down already."""
CONFIRMING_SCANS = 6
"""Scans that must hear an access point as it was surveyed until their session confirms it. Of sessions that hear a
moved, swapped, imitated or doubled one this often 22 to 65 % exclude it (decision 0011)."""
COUNTED = 1_000
"""Sessions of which this process counts such scans."""
LONGEST_REASON = 200
_log = logging.getLogger(__name__)


class WatchState(StrEnum):
    """How an access point on the list stands. Only `removed` ones are used again."""

    WATCHED = "watched"
    PERMANENT = "permanent"
    REMOVED = "removed"


@dataclass(frozen=True, slots=True)
class WatchedAccessPoint:
    """An access point on a list, and how it stands now."""

    row: WatchedRow
    state: WatchState


class WatchLists:
    """What is on the lists, and how it comes there.

    Parameters
    ----------
    now_ms : the server's clock.  needed : distinct sessions that must exclude an access point.
    share : of those that exclude it and those that confirm it together that must exclude it.
    within_hours : how long either counts.
    """

    def __init__(
        self, rows: WatchListRows, now_ms: Callable[[], int], needed: int, share: float, within_hours: float
    ) -> None:
        self._rows = rows
        self._now_ms = now_ms
        self._needed = needed
        self._share = share
        self._within_ms = round(within_hours * 3_600_000)
        self._noted: OrderedDict[tuple[str, int], set[int]] = OrderedDict()
        self._heard: OrderedDict[tuple[str, int], Counter[int]] = OrderedDict()
        self._confirmed: dict[tuple[str, int], Counter[int]] = {}

    async def listed(self, venue: str, version: int) -> list[WatchedAccessPoint]:
        """A version's list, newest first.

        Raises
        ------
        NotFound : there is no such version.
        """
        rows = await self._rows.listed(venue, version) if is_identifier(venue) else None
        if rows is None:
            raise no_version(venue, version)
        return [WatchedAccessPoint(row, self._state(row)) for row in rows]

    async def add(self, venue: str, version: int, bssid: str, reason: str) -> tuple[WatchedAccessPoint, bool]:
        """Put an access point on a list by hand; gives it, and whether it was not watched before.

        Raises
        ------
        InvalidInput : not a MAC address.
        NotFound : there is no such version.
        """
        try:
            number = parse_bssid(bssid)
        except ValueError as error:
            raise InvalidInput(str(error), "bssid") from error
        if not is_identifier(venue):
            raise no_version(venue, version)
        added = await self._rows.add(venue, version, number, reason, self._now_ms())
        if added is None:
            raise no_version(venue, version)
        return WatchedAccessPoint(added[0], self._state(added[0])), added[1]

    async def remove(self, venue: str, version: int, bssid: str) -> None:
        """Use an access point again. Exclusions do not bring it back onto this version's list; adding it does.

        Raises
        ------
        NotFound : there is no such version, or the access point is not watched.
        """
        unwatched = NotFound(
            f"access point {bssid[:40]!r} is not watched in radio map version {version} of {venue[:64]!r}"
        )
        try:
            number = parse_bssid(bssid)
        except ValueError as error:
            raise unwatched from error
        if not (is_identifier(venue) and await self._rows.remove(venue, version, number, self._now_ms())):
            raise unwatched

    async def heard(self, venue: str, site: Site, session: str, _method: str, fix: Fix) -> None:
        """Take up a new Fix of a session."""
        if site.radio_map is None:
            return
        version = site.radio_map.version
        self.confirm(venue, version, session, fix.confirmed)
        if fix.integrity.excluded:
            await self.notice(venue, version, session, fix.integrity.excluded)

    def confirm(self, venue: str, version: int, session: str, confirmed: Sequence[int]) -> None:
        """Take up what the scans of a session have heard as it was surveyed, once for each scan; costs no
        transaction: it is written down when an exclusion is, or else every few minutes."""
        if not confirmed:
            return
        scans = self._heard.setdefault((session, version), Counter())
        sessions = self._confirmed.setdefault((venue, version), Counter())
        for bssid in confirmed:
            scans[bssid] += 1
            if scans[bssid] == CONFIRMING_SCANS:
                sessions[bssid] += 1
        self._heard.move_to_end((session, version))
        if len(self._heard) > COUNTED:
            self._heard.popitem(last=False)

    async def notice(self, venue: str, version: int, session: str, excluded: Iterable[Excluded]) -> None:
        """Take up what a new Fix of a session has excluded; costs a transaction for what this session had not yet.

        A database that cannot be reached is not the phone's concern, whose Fix is stored: the next Fix tries again.
        """
        reasons = {
            one.bssid: one.reason[:LONGEST_REASON]
            for one in excluded
            if one.bssid is not None and (word := one.reason.split(maxsplit=1)) and word[0].rstrip(":,;") in REASONS
        }
        noted = self._noted.get((session, version), set())
        new = {bssid: reason for bssid, reason in reasons.items() if bssid not in noted}
        if not new:
            return
        now_ms = self._now_ms()
        digest = hashlib.sha256(session.encode()).digest()
        try:
            await self._write_confirmed(venue, version)
            listed = await self._rows.notice(
                venue, version, digest, new, now_ms, now_ms - self._within_ms, self._needed, self._share
            )
        except DependencyDown as error:
            _log.warning("exclusions are written down later: %s", error)
            return
        self._noted[session, version] = noted | new.keys()
        self._noted.move_to_end((session, version))
        if len(self._noted) > REMEMBERED:
            self._noted.popitem(last=False)
        if listed:
            _log.warning(
                "venue %s, radio map %d: %d access points are watched from now on", venue, version, len(listed)
            )

    async def forget(self) -> None:
        """Write down what is confirmed, and drop what counts no longer."""
        for venue, version in list(self._confirmed):
            await self._write_confirmed(venue, version)
        await self._rows.forget_evidence(self._now_ms() - self._within_ms)

    async def _write_confirmed(self, venue: str, version: int) -> None:
        confirmed = self._confirmed.pop((venue, version), None)
        if not confirmed:
            return
        try:
            await self._rows.confirm(venue, version, confirmed, self._now_ms())
        except DependencyDown:
            self._confirmed.setdefault((venue, version), Counter()).update(confirmed)
            raise

    def _state(self, row: WatchedRow) -> WatchState:
        if row.removed_ms is not None:
            return WatchState.REMOVED
        permanent = self._now_ms() - row.first_seen_ms >= WATCHED_MS
        return WatchState.PERMANENT if permanent else WatchState.WATCHED
