"""The wire schemas of venues and floors. Requests of administrators are strict: an unknown field is a mistake."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, Field

from app.api.json_bodies import FROM_ADMINISTRATORS, parse_admin
from app.floorplan.georeference import Georeference
from app.services.identifiers import IDENTIFIER
from app.services.venues import FloorDraft, floor_draft
from app.storage.venue_rows import FloorRow, VenueRow

NEAREST_POLE_DEG = 89.0
"""Floor frames are laid out flat about their origin, which has no east at a pole."""
LARGEST_SIDE_M = 10_000.0


def _printable(text: str) -> str:
    if not text.isprintable() or not text.strip():
        raise ValueError("a name is printable text")
    return text


Identifier = Annotated[str, Field(pattern=f"^{IDENTIFIER.pattern}$", description="unique")]
Name = Annotated[str, Field(max_length=200), AfterValidator(_printable)]
Side = Annotated[float, Field(gt=0, le=LARGEST_SIDE_M, description="m, of the floor's frame")]


class VenueBody(BaseModel):
    """A new venue; `name` is the identifier where it is left out."""

    model_config = FROM_ADMINISTRATORS

    venue: Identifier
    name: Name | None = None


class GeoreferenceBody(BaseModel):
    """Where the origin of the floor's frame lies, and the clockwise angle from north to its y axis."""

    model_config = FROM_ADMINISTRATORS

    latitude: Annotated[float, Field(ge=-NEAREST_POLE_DEG, le=NEAREST_POLE_DEG, description="degrees, WGS 84")]
    longitude: Annotated[float, Field(ge=-180, le=180, description="degrees, WGS 84")]
    rotation: Annotated[float, Field(ge=-2 * math.pi, le=2 * math.pi, description="radians")] = 0.0


class FloorBody(BaseModel):
    """A floor; `name` is the identifier where it is left out."""

    model_config = FROM_ADMINISTRATORS

    name: Name | None = None
    level: Annotated[int, Field(ge=-200, le=1000, description="storeys above ground, negative below")]
    width: Side
    height: Side
    georeference: GeoreferenceBody | None = None
    plan: Annotated[Any, Field(description="GeoJSON in WGS 84, or null")] = None


def read_floor(sent: bytes, floor: str) -> FloorDraft:
    """The floor of that identifier in a JSON body.

    Raises
    ------
    InvalidInput : not JSON, or not such a body, or a plan that cannot be drawn; names the first offending field.
    TooLarge : the plan has more elements than the bounds.
    """
    body = parse_admin(FloorBody, sent)
    place = body.georeference
    return floor_draft(
        name=floor if body.name is None else body.name,
        level=body.level,
        width_m=body.width,
        height_m=body.height,
        georeference=None if place is None else Georeference(place.latitude, place.longitude, place.rotation),
        plan=body.plan,
    )


class GeoreferenceAnswer(BaseModel):
    """Where the origin of the floor's frame lies, and the clockwise angle from north to its y axis."""

    latitude: float
    longitude: float
    rotation: float


class FloorAnswer(BaseModel):
    """A floor; its plan and image are fetched by themselves."""

    floor: str
    name: str
    level: int
    width: float
    height: float
    georeference: GeoreferenceAnswer | None
    has_plan: bool
    has_image: bool

    @classmethod
    def of(cls, row: FloorRow) -> FloorAnswer:
        """A stored floor."""
        place = row.georeference
        return FloorAnswer(
            floor=row.floor,
            name=row.name,
            level=row.level,
            width=row.width_m,
            height=row.height_m,
            georeference=None
            if place is None
            else GeoreferenceAnswer(
                latitude=place.latitude_deg, longitude=place.longitude_deg, rotation=place.rotation_rad
            ),
            has_plan=row.has_plan,
            has_image=row.has_image,
        )


class StoredFloorAnswer(FloorAnswer):
    """A floor after a change. `warnings`: what of the plan was repaired, or looks wrong."""

    warnings: list[str]


class FloorWithPlan(FloorAnswer):
    """A floor with its plan, a GeoJSON FeatureCollection."""

    plan: dict[str, Any] | None


class VenueAnswer(BaseModel):
    """A venue. `created`: Unix ms, server's clock.  `version`: of the active radio map, null until there is one."""

    venue: str
    name: str
    created: int
    version: int | None

    @classmethod
    def of(cls, row: VenueRow) -> VenueAnswer:
        """A stored venue."""
        return VenueAnswer(venue=row.venue, name=row.name, created=row.created_ms, version=row.active_version)


class VenueWithFloors(VenueAnswer):
    """A venue with its floors from the lowest up."""

    floors: list[FloorAnswer]

    @classmethod
    def of_rows(cls, row: VenueRow, floors: Iterable[FloorRow]) -> VenueWithFloors:
        """A stored venue and its floors."""
        return VenueWithFloors(**VenueAnswer.of(row).model_dump(), floors=[FloorAnswer.of(floor) for floor in floors])


class VenueListAnswer(BaseModel):
    """All venues."""

    venues: list[VenueAnswer]
