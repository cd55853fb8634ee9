"""The wire schema of a Fix and of a track, for the API page: answers are sent as stored, not built from these."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import orjson
from pydantic import BaseModel, Field

from app.observations import Carrying, Flag, Motion
from app.storage.session_rows import FixRow


class PositionBody(BaseModel):
    """A place on a floor; latitude and longitude are null on a floor without a georeference."""

    x: Annotated[float, Field(description="m, east")]
    y: Annotated[float, Field(description="m, north")]
    floor: str
    latitude: float | None
    longitude: float | None


class ExcludedBody(BaseModel):
    """An observation or an access point that was left out, and why."""

    observation: str | None = None
    bssid: str | None = None
    reason: str


class IntegrityBody(BaseModel):
    """Whether the position can be trusted."""

    flag: Flag
    usable: Annotated[bool, Field(description="no fault, the floor certain, and protection_level <= alert_limit")]
    if1: int
    if2: int
    if3: int
    statistic: float | None
    threshold: float | None
    protection_level: Annotated[float | None, Field(description="m")]
    alert_limit: Annotated[float, Field(description="m")]
    risk: float
    excluded: list[ExcludedBody]


class FixBody(BaseModel):
    """The best estimate at `t`. While `position` is null the estimates are null too."""

    session: str
    sequence: Annotated[int, Field(description="of the batch that it answers; -1 before the first")]
    t: Annotated[int | None, Field(description="Unix epoch ms of the phone's clock: the newest time accounted for")]
    dropped: Annotated[int, Field(description="unusable readings and pressures of the batch")]
    gap: Annotated[bool, Field(description="batches are missing before this one")]
    position: PositionBody | None
    accuracy: Annotated[float | None, Field(description="68 % radius, m")]
    covariance: Annotated[list[list[float]] | None, Field(description="[[xx, xy], [xy, yy]], m^2")]
    heading: Annotated[float | None, Field(description="rad clockwise from north")]
    speed: Annotated[float | None, Field(description="m/s")]
    steps: int
    motion: Motion
    carrying: Carrying
    integrity: IntegrityBody
    smoothed: Annotated[bool, Field(description="present and true in a smoothed track, else absent")] = False


class TrackBody(BaseModel):
    """A page of a track."""

    session: str
    fixes: list[FixBody]
    next: Annotated[str | None, Field(description="cursor of the next page; null on the last")]


class FeatureCollectionBody(BaseModel):
    """A page of a track as GeoJSON: a Point per Fix; `geometry` is null where WGS 84 is not known."""

    type: Literal["FeatureCollection"]
    features: list[dict[str, Any]]
    next: str | None


def track_document(session: str, rows: list[FixRow], cursor: str | None) -> bytes:
    """A page of stored fixes, each as it was answered."""
    fixes = b",".join(row.body for row in rows)
    return b'{"session":%b,"fixes":[%b],"next":%b}' % (orjson.dumps(session), fixes, orjson.dumps(cursor))


def geojson_document(rows: list[FixRow], cursor: str | None) -> bytes:
    """The same page as GeoJSON; a Fix without position or georeference has no geometry (RFC 7946, 3.2)."""
    return orjson.dumps({"type": "FeatureCollection", "features": [_feature(row) for row in rows], "next": cursor})


def _feature(row: FixRow) -> dict[str, Any]:
    fix = orjson.loads(row.body)
    position, integrity = fix["position"], fix["integrity"]
    located = position is not None and position["latitude"] is not None
    return {
        "type": "Feature",
        "id": row.sequence,
        "geometry": {"type": "Point", "coordinates": [position["longitude"], position["latitude"]]}
        if located
        else None,
        "properties": {
            "t": fix["t"],
            "floor": None if position is None else position["floor"],
            **{name: fix[name] for name in ("accuracy", "heading", "speed", "motion")},
            **{name: integrity[name] for name in ("flag", "usable", "protection_level")},
            **({"smoothed": True} if "smoothed" in fix else {}),
        },
    }
