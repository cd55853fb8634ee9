"""Venues, their floors and plans."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import orjson

from app.errors import Conflict, InvalidInput, NotFound
from app.floorplan.georeference import Georeference
from app.floorplan.plan import accept_plan
from app.floorplan.plan_image import refuse_unusable_png
from app.services.identifiers import is_identifier, no_venue, refuse_identifier
from app.storage.venue_rows import FloorRow, VenueRow, VenueRows
from app.survey.admission import FloorExtent

FAR_DEG = 0.5
"""A plan whose positions all lie farther from its georeference is of another place, or has its axes swapped."""


@dataclass(frozen=True, slots=True)
class FloorDraft:
    """A floor as an administrator describes it. plan : GeoJSON as it is stored.  warnings : what of it was repaired or
    looks wrong."""

    name: str
    level: int
    width_m: float
    height_m: float
    georeference: Georeference | None
    plan: bytes | None
    warnings: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class StoredFloor:
    """A floor after a change. created : it is new.  warnings : of its draft."""

    row: FloorRow
    created: bool
    warnings: tuple[str, ...]


class Venues:
    """What administrators may do with venues, and who draws them may read.

    Every method raises NotFound for an unknown venue or floor, and DependencyDown, having changed nothing, where the
    database cannot be reached.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(self, rows: VenueRows, now_ms: Callable[[], int]) -> None:
        self._rows = rows
        self._now_ms = now_ms

    async def create(self, venue: str, name: str) -> VenueRow:
        """A new venue without floors.

        Raises
        ------
        InvalidInput : the identifier is not one.
        Conflict : there is a venue of that identifier.
        """
        refuse_identifier(venue, "venue")
        if not await self._rows.add(venue, name, self._now_ms()):
            raise Conflict(f"there is a venue {venue!r} already")
        return (await self.read(venue))[0]

    async def key(self, venue: str) -> int:
        """What the other tables know a venue by."""
        key = await self._rows.key(venue) if is_identifier(venue) else None
        if key is None:
            raise no_venue(venue)
        return key

    async def listed(self) -> list[VenueRow]:
        """Every venue, oldest first."""
        return await self._rows.listed()

    async def read(self, venue: str) -> tuple[VenueRow, list[FloorRow]]:
        """A venue and its floors from the lowest up."""
        found = await self._rows.read(venue) if is_identifier(venue) else None
        if found is None:
            raise no_venue(venue)
        return found

    async def floor(self, venue: str, floor: str) -> tuple[FloorRow, bytes | None]:
        """A floor and its plan."""
        row = await self._row(venue, floor)
        return row, await self._rows.read_plan(venue, floor) if row.has_plan else None

    async def put_floor(self, venue: str, floor: str, draft: FloorDraft) -> StoredFloor:
        """Make a floor, or replace everything of it but its image.

        Raises
        ------
        InvalidInput : the identifier is not one; names the field.
        """
        refuse_identifier(floor, "floor")
        place = draft.georeference
        values = {
            "name": draft.name,
            "level": draft.level,
            "width_m": draft.width_m,
            "height_m": draft.height_m,
            "latitude_deg": None if place is None else place.latitude_deg,
            "longitude_deg": None if place is None else place.longitude_deg,
            "rotation_rad": None if place is None else place.rotation_rad,
            "plan": draft.plan,
        }
        created = await self._rows.put_floor(venue, floor, values) if is_identifier(venue) else None
        if created is None:
            raise no_venue(venue)
        return StoredFloor(await self._row(venue, floor), created, draft.warnings)

    async def put_image(self, venue: str, floor: str, body: bytes) -> None:
        """Set a floor's raster plan, a PNG.

        Raises
        ------
        InvalidInput : not a whole PNG.
        TooLarge : more pixels than can be shown.
        """
        await asyncio.to_thread(refuse_unusable_png, body)
        known = is_identifier(venue) and is_identifier(floor)
        if not known or not await self._rows.put_image(venue, floor, body):
            raise NotFound(f"there is no floor {floor[:64]!r} of a venue {venue[:64]!r}")

    async def image(self, venue: str, floor: str) -> bytes:
        """A floor's raster plan; NotFound also where it has none."""
        await self._row(venue, floor)
        image = await self._rows.read_image(venue, floor)
        if image is None:
            raise NotFound(f"floor {floor} has no image")
        return image

    async def plan(self, venue: str, floor: str) -> bytes:
        """A floor's plan, GeoJSON; NotFound also where it has none."""
        _, plan = await self.floor(venue, floor)
        if plan is None:
            raise NotFound(f"floor {floor} has no plan")
        return plan

    async def _row(self, venue: str, floor: str) -> FloorRow:
        _, found = await self.read(venue)
        row = next((one for one in found if one.floor == floor), None)
        if row is None:
            raise NotFound(f"venue {venue} has no floor {floor[:64]!r}")
        return row


def floor_extent(row: FloorRow) -> FloorExtent:
    """A stored floor as surveys are held against it."""
    return FloorExtent(row.floor, row.width_m, row.height_m)


def floor_draft(
    name: str, level: int, width_m: float, height_m: float, georeference: Georeference | None, plan: Any
) -> FloorDraft:
    """A floor, of a plan that has not been looked at: decoded JSON, or None.

    Raises
    ------
    InvalidInput : the plan cannot be drawn; names the element.
    TooLarge : it has more of them than the bounds.
    """
    if plan is None:
        return FloorDraft(name, level, width_m, height_m, georeference, None)
    accepted = accept_plan(plan)
    warnings = list(accepted.warnings)
    if georeference is None:
        warnings.append("without a georeference the plan cannot be placed on the floor (georeference)")
    elif accepted.bounds is not None and _is_far(georeference, accepted.bounds):
        warnings.append("the plan lies far away from the georeference; is either in longitude, latitude order? (plan)")
    try:
        stored = orjson.dumps(accepted.plan)
    except orjson.JSONEncodeError as error:
        raise InvalidInput("the plan is nested too deeply", "plan") from error
    return FloorDraft(name, level, width_m, height_m, georeference, stored, tuple(warnings))


def _is_far(place: Georeference, bounds: tuple[float, float, float, float]) -> bool:
    west, south, east, north = bounds
    outside_longitude = max(west - place.longitude_deg, place.longitude_deg - east)
    outside_latitude = max(south - place.latitude_deg, place.latitude_deg - north)
    return max(outside_longitude, outside_latitude) > FAR_DEG
