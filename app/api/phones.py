"""GET /v1/venues/{venue}/phones: what the console polls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Depends

from app.services.phones import Phones


def phones_router(listing: Callable[..., Any], admin: Callable[..., Any]) -> APIRouter:
    """The listing of live phones.

    Parameters
    ----------
    listing : dependency that gives the Phones.  admin : dependency that lets only scope `admin` pass.
    """
    router = APIRouter(tags=["venues"], dependencies=[Depends(admin)])

    @router.get("/v1/venues/{venue}/phones", summary="Live phones of a venue with their newest fixes")
    async def phones(venue: str, service: Phones = Depends(listing)) -> dict[str, list[dict[str, Any]]]:
        """Phones heard of within the last minute. `phone` is an opaque number, not the session id."""
        return {"phones": await service.live(venue)}

    return router
