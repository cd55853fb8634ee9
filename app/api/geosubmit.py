"""POST /v2/geosubmit: the body, answer and errors of the geosubmit v2 API, as survey apps send and expect them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fastapi import APIRouter, Depends, Request
from fastapi.responses import JSONResponse

from app.api import examples
from app.api.decoding import read_body
from app.api.geolocate_errors import RESPONSES, GeolocateRoute
from app.api.json_bodies import request_body
from app.services.geosubmission import Geosubmission

BODY_LIMIT_BYTES = 20_000_000
_POINT = {
    "type": "object",
    "required": ["macAddress"],
    "properties": {
        "macAddress": {"type": "string"},
        "signalStrength": {"type": "number", "description": "dBm"},
        "age": {"type": "number", "description": "ms"},
        "frequency": {"type": "number", "description": "MHz"},
        "ssid": {"type": "string"},
    },
}
_POSITION = {
    "type": "object",
    "required": ["latitude", "longitude"],
    "properties": {
        "latitude": {"type": "number", "description": "degrees, WGS 84"},
        "longitude": {"type": "number", "description": "degrees, WGS 84"},
        "accuracy": {"type": "number", "description": "m; above 25 the report is left out"},
        "age": {"type": "number", "description": "ms"},
        "floor": {"type": "string", "description": "ours: which of the floors above one another"},
    },
}
_REPORT = {
    "type": "object",
    "required": ["position", "wifiAccessPoints"],
    "properties": {
        "timestamp": {"type": "number", "description": "Unix ms; default now"},
        "position": _POSITION,
        "wifiAccessPoints": {"type": "array", "items": _POINT},
    },
}
_SCHEMA = {"type": "object", "required": ["items"], "properties": {"items": {"type": "array", "items": _REPORT}}}


def geosubmit_router(geosubmission: Callable[..., Any], survey: Callable[..., Any]) -> APIRouter:
    """The endpoint.

    Parameters
    ----------
    geosubmission : dependency that gives the Geosubmission.
    survey : dependency that lets only scope `survey` pass, also by `?key=`.
    """
    router = APIRouter(tags=["compatible"], dependencies=[Depends(survey)], route_class=GeolocateRoute)

    @router.post(
        "/v2/geosubmit",
        responses=RESPONSES,
        summary="Report scans by latitude and longitude",
        openapi_extra=request_body(_SCHEMA, example=examples.GEOSUBMIT),
    )
    async def geosubmit(request: Request, service: Geosubmission = Depends(geosubmission)) -> Any:
        """Each report goes to the floor whose georeferenced frame contains its position: of floors above one another
        the ground floor, or the one that `position.floor` names. Reports that cannot be used are left out silently, as
        the format has it. Networks whose name ends in `_nomap` are not stored.
        """
        await service.add(await read_body(request, BODY_LIMIT_BYTES))
        return JSONResponse({})

    return router
