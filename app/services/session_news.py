"""What other workers have stored in the sessions that somebody here listens to: one look for all of them."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable

from app.errors import DependencyDown
from app.services.announcements import Announcements
from app.storage.session_rows import SessionRows

LOOK_EVERY_S = 1.0
"""Fixes that another worker made are found after so long."""
_log = logging.getLogger(__name__)


class SessionNews:
    """Announces every session that has moved on or ended unannounced, and each when it is first listened to.

    Parameters
    ----------
    announcements : of this process.  now_ms : the server's clock.
    """

    def __init__(self, rows: SessionRows, announcements: Announcements, now_ms: Callable[[], int]) -> None:
        self._rows = rows
        self._announcements = announcements
        self._now_ms = now_ms

    async def run(self) -> None:
        """Look for ever; ends by being cancelled."""
        while True:
            await asyncio.sleep(LOOK_EVERY_S)
            try:
                await self.look()
            except DependencyDown as error:
                _log.warning("listeners hear of other workers' fixes later: %s", error)

    async def look(self) -> None:
        """Announce what is new; asks the database only while somebody listens."""
        listened = self._announcements.sessions()
        live = await self._rows.sequences(listened, self._now_ms()) if listened else {}
        for session in listened:
            if self._announcements.is_news(session, live.get(session)):
                self._announcements.announce(session, live.get(session))
