"""Word inside one process that a session has something new. Other workers' news: app/services/session_news.py."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager

ALERTS = "alerts"
"""Announced like a session when an alert of any of them was stored."""


class Announcements:
    """Wakes those who wait for a session."""

    def __init__(self) -> None:
        self._waiting: dict[str, set[asyncio.Event]] = {}
        self._newest: dict[str, int | None] = {}

    def sessions(self) -> list[str]:
        """Those that somebody listens to."""
        return [session for session in self._waiting if session != ALERTS]

    def listeners(self, session: str) -> int:
        """How many listen to one."""
        return len(self._waiting.get(session, ()))

    def announce(self, session: str, sequence: int | None = None) -> None:
        """Wake everyone who listens to that session. sequence : of its newest Fix, None once it is over."""
        for event in self._waiting.get(session, ()):
            event.set()
            self._newest[session] = sequence

    def is_news(self, session: str, sequence: int | None) -> bool:
        """Whether those who listen to a session have not been told that this is its newest Fix."""
        return session not in self._newest or self._newest[session] != sequence

    @contextmanager
    def listen(self, session: str) -> Iterator[asyncio.Event]:
        """An event that every announcement sets; the listener clears it."""
        event = asyncio.Event()
        self._waiting.setdefault(session, set()).add(event)
        try:
            yield event
        finally:
            listeners = self._waiting[session]
            listeners.discard(event)
            if not listeners:
                del self._waiting[session]
                self._newest.pop(session, None)
