"""Who else wants to know of a new Fix, once it is stored."""

from __future__ import annotations

from collections.abc import Awaitable, Callable

from app.fusion.interface import Site
from app.observations import Fix

FixListener = Callable[[str, Site, str, str, Fix], Awaitable[None]]
"""Of venue, the Site that was used, session, its method, and Fix. The phone's answer waits for it: it returns at once,
or seldom does not, and what it could not do is not the phone's concern."""
