"""The server's own clock: for expiry, retention and when things were made. No phone's time is compared with it."""

from __future__ import annotations

import time


def server_ms() -> int:
    """Unix time in ms."""
    return time.time_ns() // 1_000_000
