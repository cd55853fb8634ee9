"""POST /v1/geolocate: the request, answer and errors that Google's and Mozilla's geolocation services share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Depends, Request
from pydantic import BaseModel, Field, TypeAdapter, ValidationError

from app.api import examples
from app.api.batch_body import LARGEST_SCAN
from app.api.batch_scans import wifi_scan
from app.api.decoding import read_body
from app.api.geolocate_errors import RESPONSES, GeolocateRoute
from app.api.json_bodies import FROM_PHONES, inlined_schema, refusal
from app.errors import NotFound
from app.observations import WifiScan
from app.services.geolocation import Geolocation
from app.survey.admission import LATEST_MS

BODY_LIMIT_BYTES = 1_000_000
REFERENCE_MS = LATEST_MS / 2
"""Stands for now: only ages matter, and the answer must not depend on the server's clock."""
LARGEST_AGE_MS = 86_400_000.0


class AccessPointBody(BaseModel):
    """An access point that was heard. `age`: ms since then."""

    model_config = FROM_PHONES

    mac_address: Annotated[Any, Field(alias="macAddress")] = None
    signal_strength: Annotated[float | None, Field(alias="signalStrength", description="dBm")] = None
    age: Annotated[float | None, Field(ge=0)] = None


class GeolocateBody(BaseModel):
    """Only `wifiAccessPoints` is used; cell towers and the sender's address are not."""

    model_config = FROM_PHONES

    wifi: Annotated[list[AccessPointBody], Field(alias="wifiAccessPoints", max_length=LARGEST_SCAN)] = []


class LocationBody(BaseModel):
    """WGS 84, degrees."""

    lat: float
    lng: float


class GeolocateAnswer(BaseModel):
    """`accuracy`: 68 % radius, m."""

    location: LocationBody
    accuracy: float


_BODY = TypeAdapter(GeolocateBody)
_CONTENT = {"schema": inlined_schema(GeolocateBody), "example": examples.GEOLOCATE}
_REQUEST = {"requestBody": {"content": {"application/json": _CONTENT}}}


def geolocate_router(geolocation: Callable[..., Any], position: Callable[..., Any]) -> APIRouter:
    """The endpoint.

    Parameters
    ----------
    geolocation : dependency that gives the Geolocation.
    position : dependency that lets only scope `position` pass, also by `?key=`.
    """
    router = APIRouter(tags=["compatible"], dependencies=[Depends(position)], route_class=GeolocateRoute)

    @router.post(
        "/v1/geolocate",
        response_model=GeolocateAnswer,
        responses=RESPONSES,
        summary="Where one scan was taken, over all venues",
        openapi_extra=_REQUEST,
    )
    async def geolocate(request: Request, service: Geolocation = Depends(geolocation)) -> Any:
        """Venues whose floors have a georeference and whose radio map knows two of the access points or more."""
        place = await service.place(parse_scan(await read_body(request, BODY_LIMIT_BYTES)))
        if place is None:
            raise NotFound("Not found")
        location = LocationBody(lat=place.latitude_deg, lng=place.longitude_deg)
        return GeolocateAnswer(location=location, accuracy=place.accuracy_m)

    return router


def parse_scan(sent: bytes) -> WifiScan:
    """The scan of a Geolocate body; access points without usable address or signal strength are left out.

    Raises
    ------
    InvalidInput : not such a body; names the first offending field.
    """
    try:
        body = _BODY.validate_json(sent or b"{}")
    except ValidationError as error:
        raise refusal(error) from error
    readings = [
        {
            "bssid": one.mac_address,
            "rssi": one.signal_strength,
            "seen": REFERENCE_MS - min(one.age or 0.0, LARGEST_AGE_MS),
        }
        for one in body.wifi
        if one.signal_strength is not None
    ]
    return wifi_scan(REFERENCE_MS, REFERENCE_MS / 1000.0, readings)[0]
