"""Venues, floors and plans: what administrators set up, and who draws a map reads."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import orjson
from fastapi import APIRouter, Depends, Request, Response

from app.api import examples
from app.api.decoding import read_body
from app.api.json_bodies import parse_admin, read_json, request_body
from app.api.venue_body import (
    FloorAnswer,
    FloorBody,
    FloorWithPlan,
    StoredFloorAnswer,
    VenueAnswer,
    VenueBody,
    VenueListAnswer,
    VenueWithFloors,
    read_floor,
)
from app.errors import UnsupportedMedia
from app.services.venues import Venues
from app.services.worker_processes import WorkerProcesses

VENUE_LIMIT_BYTES = 100_000
FLOOR_LIMIT_BYTES = 50_000_000
IMAGE_LIMIT_BYTES = 25_000_000
GEOJSON = "application/geo+json"
PNG = "image/png"
_IMAGE_TYPES = frozenset({"", PNG, "application/octet-stream"})
_STORED = {"X-Content-Type-Options": "nosniff", "Cache-Control": "private, no-cache"}


def _binary(media_type: str, schema: dict[str, Any]) -> dict[int | str, dict[str, Any]]:
    return {200: {"content": {media_type: {"schema": schema}}}}


def venues_router(
    venues: Callable[..., Any], read: Callable[..., Any], admin: Callable[..., Any], workers: WorkerProcesses
) -> APIRouter:
    """The endpoints of venues.

    Parameters
    ----------
    venues : dependency that gives the Venues.  read : dependency that lets any key pass.  admin : dependency that
    lets only scope `admin` pass.  workers : read large plans.
    """
    router = APIRouter(prefix="/v1/venues", tags=["venues"])
    _add_venues(router, venues, read, admin)
    _add_floors(router, venues, read, admin, workers)
    _add_images(router, venues, read, admin)
    return router


def _add_venues(
    router: APIRouter, venues: Callable[..., Any], read: Callable[..., Any], admin: Callable[..., Any]
) -> None:
    @router.post(
        "",
        status_code=201,
        response_model=VenueWithFloors,
        dependencies=[Depends(admin)],
        summary="Create a venue",
        openapi_extra=request_body(VenueBody, example=examples.VENUE),
    )
    async def create(request: Request, response: Response, service: Venues = Depends(venues)) -> VenueWithFloors:
        """A building or site. It is empty until it has floors; an identifier that is taken is 409."""
        body = parse_admin(VenueBody, await read_json(request, VENUE_LIMIT_BYTES))
        row = await service.create(body.venue, body.name if body.name is not None else body.venue)
        response.headers["Location"] = f"/v1/venues/{row.venue}"
        return VenueWithFloors.of_rows(row, [])

    @router.get("", response_model=VenueListAnswer, dependencies=[Depends(read)], summary="All venues")
    async def listed(service: Venues = Depends(venues)) -> VenueListAnswer:
        """Oldest first."""
        return VenueListAnswer(venues=[VenueAnswer.of(row) for row in await service.listed()])

    @router.get("/{venue}", response_model=VenueWithFloors, dependencies=[Depends(read)], summary="One venue")
    async def one(venue: str, service: Venues = Depends(venues)) -> VenueWithFloors:
        """With its floors from the lowest up; their plans are at the floors."""
        return VenueWithFloors.of_rows(*await service.read(venue))


def _add_floors(
    router: APIRouter,
    venues: Callable[..., Any],
    read: Callable[..., Any],
    admin: Callable[..., Any],
    workers: WorkerProcesses,
) -> None:
    @router.put(
        "/{venue}/floors/{floor}",
        response_model=StoredFloorAnswer,
        responses={201: {"model": StoredFloorAnswer, "description": "The floor is new"}},
        dependencies=[Depends(admin)],
        summary="Make or replace a floor",
        openapi_extra=request_body(FloorBody, example=examples.FLOOR),
    )
    async def put_floor(
        venue: str, floor: str, request: Request, response: Response, service: Venues = Depends(venues)
    ) -> StoredFloorAnswer:
        """Replaces the whole floor: `georeference` and `plan` are null afterwards if they are left out. The image
        stays; it is a resource of its own.

        `plan` is GeoJSON in WGS 84. Foreign members and the old `crs` are kept; rings are closed and wound as RFC 7946
        asks; `warnings` of the answer says what was done. What cannot be drawn is 422 with its path.
        """
        sent = await read_json(request, FLOOR_LIMIT_BYTES)
        stored = await service.put_floor(venue, floor, await workers.run_of(len(sent), read_floor, sent, floor))
        response.status_code = 201 if stored.created else 200
        return StoredFloorAnswer(**FloorAnswer.of(stored.row).model_dump(), warnings=list(stored.warnings))

    @router.get(
        "/{venue}/floors/{floor}",
        responses={200: {"model": FloorWithPlan}},
        response_class=Response,
        dependencies=[Depends(read)],
        summary="A floor with its plan",
    )
    async def floor_with_plan(venue: str, floor: str, service: Venues = Depends(venues)) -> Response:
        """`plan` is a GeoJSON FeatureCollection, or null."""
        row, plan = await service.floor(venue, floor)
        document = {**FloorAnswer.of(row).model_dump(), "plan": None if plan is None else orjson.Fragment(plan)}
        return Response(orjson.dumps(document), media_type="application/json")

    @router.get(
        "/{venue}/floors/{floor}/plan",
        responses=_binary(GEOJSON, {"type": "object"}),
        response_class=Response,
        dependencies=[Depends(read)],
        summary="The plan alone",
    )
    async def plan(venue: str, floor: str, service: Venues = Depends(venues)) -> Response:
        """A GeoJSON FeatureCollection; 404 where there is none."""
        return Response(await service.plan(venue, floor), media_type=GEOJSON, headers=_STORED)


def _add_images(
    router: APIRouter, venues: Callable[..., Any], read: Callable[..., Any], admin: Callable[..., Any]
) -> None:
    png = {"type": "string", "format": "binary"}

    @router.put(
        "/{venue}/floors/{floor}/image",
        status_code=204,
        response_class=Response,
        dependencies=[Depends(admin)],
        summary="Set the raster plan",
        openapi_extra=request_body(png, PNG),
    )
    async def put_image(venue: str, floor: str, request: Request, service: Venues = Depends(venues)) -> Response:
        """A PNG that spans the floor's frame exactly, north up, its lower left corner the origin."""
        sent_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
        if sent_type not in _IMAGE_TYPES:
            raise UnsupportedMedia(f"an image is sent as {PNG}, not {sent_type[:80]!r}")
        await service.put_image(venue, floor, await read_body(request, IMAGE_LIMIT_BYTES))
        return Response(status_code=204)

    @router.get(
        "/{venue}/floors/{floor}/image",
        responses=_binary(PNG, png),
        response_class=Response,
        dependencies=[Depends(read)],
        summary="The raster plan",
    )
    async def image(venue: str, floor: str, service: Venues = Depends(venues)) -> Response:
        """As it was sent; 404 where there is none."""
        return Response(await service.image(venue, floor), media_type=PNG, headers=_STORED)
