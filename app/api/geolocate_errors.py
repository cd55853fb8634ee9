"""Errors in the form that Google's and Mozilla's geolocation services share, where a problem document would be strange.

`{"error": {"code": 404, "message": "...", "errors": [{"domain": "geolocation", "reason": "notFound",
"message": "..."}]}}`
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Coroutine, Mapping
from typing import Any

from fastapi import Request, Response
from fastapi.responses import JSONResponse
from fastapi.routing import APIRoute
from pydantic import BaseModel

from app.api.problems import headers_of
from app.errors import (
    DependencyDown,
    InvalidInput,
    NotAllowed,
    NotFound,
    SurefixError,
    TooLarge,
    Unauthenticated,
    told_as,
)

_FORMS: Mapping[type[SurefixError], tuple[int, str, str]] = {
    InvalidInput: (400, "global", "parseError"),
    TooLarge: (413, "global", "uploadTooLarge"),
    NotFound: (404, "geolocation", "notFound"),
    Unauthenticated: (401, "usageLimits", "keyInvalid"),
    NotAllowed: (403, "usageLimits", "accessNotConfigured"),
    DependencyDown: (503, "global", "backendError"),
}
"""Status, domain and reason of an error or of the nearest class above it."""
_log = logging.getLogger(__name__)


class ReasonBody(BaseModel):
    """Why a request failed."""

    domain: str
    reason: str
    message: str


class FailureBody(BaseModel):
    """A request that failed. `code`: the status."""

    errors: list[ReasonBody]
    code: int
    message: str


class GeolocateErrorBody(BaseModel):
    """The error body that these services share."""

    error: FailureBody


_SAID = ", ".join(f"`{reason}` ({status})" for status, _, reason in _FORMS.values())
RESPONSES: dict[int | str, dict[str, Any]] = {
    "default": {"model": GeolocateErrorBody, "description": f"Anything else; `reason` is one of {_SAID}"}
}


class GeolocateRoute(APIRoute):
    """A route that tells errors so; what is not in the table is answered as everywhere."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """The handler, dependencies included."""
        handle = super().get_route_handler()

        async def handled(request: Request) -> Response:
            try:
                return await handle(request)
            except (SurefixError, OSError) as error:
                told = told_as(error)
                form = next((_FORMS[kind] for kind in type(told).__mro__ if kind in _FORMS), None)
                if form is None:
                    raise
                if isinstance(told, DependencyDown):
                    _log.warning("%s %s: %s", request.method, request.url.path, told)
                return _answer(told, *form)

        return handled


def _answer(error: Exception, status: int, domain: str, reason: str) -> JSONResponse:
    message = str(error)
    if isinstance(error, InvalidInput):
        message = f"Parse Error: {error.field}: {error}" if error.field else f"Parse Error: {error}"
    found = ReasonBody(domain=domain, reason=reason, message=message)
    body = GeolocateErrorBody(error=FailureBody(errors=[found], code=status, message=message))
    return JSONResponse(body.model_dump(), status, headers_of(error))
