"""GET /v1/venues/{venue}/phones: what the console polls."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Depends

from app.services.phones import FixReader, live_phones


def phones_router(reader: Callable[..., Any], admin: Callable[..., Any]) -> APIRouter:
    """The listing of live phones.

    Parameters
    ----------
    reader : dependency that gives the FixReader.  admin : dependency that lets only scope `admin` pass.
    """
    router = APIRouter(tags=["venues"], dependencies=[Depends(admin)])

    @router.get("/v1/venues/{venue}/phones", summary="Live phones of a venue with their newest fixes")
    async def phones(venue: str, fixes: FixReader = Depends(reader)) -> dict[str, list[dict[str, Any]]]:
        """Phones heard of within the last minute. `phone` is an opaque number, not the session id."""
        return {"phones": await live_phones(fixes, venue, time.time())}

    return router
