"""Short-lived tickets to a session's events, for browsers, which cannot send headers there.

A ticket is its expiry and an HMAC of it under the session's own secret key, so any worker can check it and none
stores it.
"""

from __future__ import annotations

import hashlib
import hmac

from app.errors import Unauthenticated

LIFETIME_MS = 60_000
"""To connect with; a connection that stands may stay longer."""
_LONGEST = 100


def issue_ticket(key: bytes, now_ms: int) -> tuple[str, int]:
    """A ticket and when it expires, Unix ms."""
    expires_ms = now_ms + LIFETIME_MS
    return f"{expires_ms}.{_seal(key, str(expires_ms))}", expires_ms


def check_ticket(ticket: str, key: bytes, now_ms: int) -> None:
    """Nothing, if the ticket is this session's and still good.

    Raises
    ------
    Unauthenticated : it is not.
    """
    expires, _, seal = ticket.partition(".")
    genuine = len(ticket) <= _LONGEST and hmac.compare_digest(
        _seal(key, expires).encode(), seal.encode("utf-8", "replace")
    )
    if not key or not genuine or int(expires) < now_ms:
        raise Unauthenticated("the ticket is unknown or has expired")


def _seal(key: bytes, expires: str) -> str:
    return hmac.new(key, f"events {expires}".encode("utf-8", "replace"), hashlib.sha256).hexdigest()
