"""Radio-map versions: list them, build one of chosen surveys, make one the active one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Path, Request
from pydantic import BaseModel, Field

from app.api import examples
from app.api.json_bodies import FROM_ADMINISTRATORS, parse_admin, read_json, request_body
from app.services.radio_maps import RadioMaps
from app.storage.radio_map_rows import VersionRow

BODY_LIMIT_BYTES = 1_000_000
Version = Annotated[int, Path(ge=1, lt=1 << 31)]
"""Number of a version in a path."""


class BuildBody(BaseModel):
    """The surveys to build a version of."""

    model_config = FROM_ADMINISTRATORS

    surveys: Annotated[list[Annotated[int, Field(ge=1, lt=1 << 63)]], Field(min_length=1, max_length=100_000)]


class ActivateBody(BaseModel):
    """The version to make active."""

    model_config = FROM_ADMINISTRATORS

    version: Annotated[int, Field(ge=1, lt=1 << 31)]


class SummaryBody(BaseModel):
    """Counts. `beacons`: Bluetooth ones. `floors`: fingerprints by floor."""

    fingerprints: int
    reference_points: int
    access_points: int
    beacons: int = 0
    floors: dict[str, int]


class VersionBody(BaseModel):
    """A version; it never changes. `created`: Unix ms, server's clock."""

    version: int
    active: bool
    created: int
    surveys: list[int]
    summary: SummaryBody


class VersionListBody(BaseModel):
    """All versions. `active`: number of the active one, null until there is one."""

    active: int | None
    radio_maps: list[VersionBody]


class ActiveBody(BaseModel):
    """The active version."""

    version: int


def radio_maps_router(radio_maps: Callable[..., Any], read: Callable[..., Any], admin: Callable[..., Any]) -> APIRouter:
    """The endpoints.

    Parameters
    ----------
    radio_maps : dependency that gives the RadioMaps.  read : dependency that lets readers of venues pass.
    admin : dependency that lets only pass who may change venues.
    """
    router = APIRouter(prefix="/v1/venues/{venue}", tags=["surveys"])

    @router.get(
        "/radio-maps", response_model=VersionListBody, dependencies=[Depends(read)], summary="All radio-map versions"
    )
    async def listed(venue: str, service: RadioMaps = Depends(radio_maps)) -> VersionListBody:
        """Oldest first."""
        rows = await service.listed(venue)
        active = next((row.version for row in rows if row.active), None)
        return VersionListBody(active=active, radio_maps=[_version(row) for row in rows])

    @router.post(
        "/radio-maps",
        status_code=201,
        response_model=VersionBody,
        dependencies=[Depends(admin)],
        summary="Build a version of chosen surveys",
        openapi_extra=request_body(BuildBody, example=examples.BUILD),
    )
    async def build(venue: str, request: Request, service: RadioMaps = Depends(radio_maps)) -> VersionBody:
        """It is not active until it is made so."""
        body = parse_admin(BuildBody, await read_json(request, BODY_LIMIT_BYTES))
        return _version(await service.build(venue, body.surveys))

    @router.put(
        "/radio-map",
        response_model=ActiveBody,
        dependencies=[Depends(admin)],
        summary="Make a version the active one",
        openapi_extra=request_body(ActivateBody, example=examples.ACTIVATE),
    )
    async def activate(venue: str, request: Request, service: RadioMaps = Depends(radio_maps)) -> ActiveBody:
        """Newer or older; running sessions move to it at their next scan."""
        body = parse_admin(ActivateBody, await read_json(request, BODY_LIMIT_BYTES))
        await service.activate(venue, body.version)
        return ActiveBody(version=body.version)

    return router


def _version(row: VersionRow) -> VersionBody:
    return VersionBody(
        version=row.version,
        active=row.active,
        created=row.created_ms,
        surveys=list(row.surveys),
        summary=SummaryBody(**row.summary),
    )
