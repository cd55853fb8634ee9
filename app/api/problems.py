"""Every error as an RFC 9457 problem document: the one table from app/errors.py to statuses."""

from __future__ import annotations

import http
import json
import logging
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException

from app.api.json_bodies import field_path
from app.errors import (
    Conflict,
    DependencyDown,
    Expired,
    Forbidden,
    InvalidInput,
    NotFound,
    NotLocal,
    SurefixError,
    TooLarge,
    Unauthenticated,
    UnsupportedMedia,
    told_as,
)

MEDIA_TYPE = "application/problem+json"
TYPE = "urn:surefix:problem:"
LONGEST_FIELD = 300
MOST_ERRORS = 20
_WITH_BODY = frozenset({"POST", "PUT", "PATCH"})
_PATH_PART = re.compile(r"\[(\d+)\]|[^.\[]+|\[")
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Problem:
    """How a kind of error is answered. name : last part of the stable `type`.  title : the same each time."""

    status: int
    name: str
    title: str


PROBLEMS: Mapping[type[SurefixError], Problem] = {
    InvalidInput: Problem(422, "invalid-input", "The input cannot be used"),
    TooLarge: Problem(413, "too-large", "The input is beyond a documented bound"),
    UnsupportedMedia: Problem(415, "unsupported-media", "The media type or encoding is not read here"),
    NotFound: Problem(404, "not-found", "There is no such thing"),
    Expired: Problem(410, "expired", "The session is over"),
    Conflict: Problem(409, "conflict", "The request contradicts what is stored"),
    Unauthenticated: Problem(401, "unauthenticated", "A valid API key is needed"),
    Forbidden: Problem(403, "forbidden", "The API key lacks the scope"),
    NotLocal: Problem(403, "forbidden", "Without API keys only this machine is answered"),
    DependencyDown: Problem(503, "dependency-down", "A store cannot be reached; nothing was changed"),
}
DEFECT = Problem(500, "defect", "The service has a defect")
DEFECT_DETAIL = "the request could not be answered; the log of the server says why"


def install_problems(app: FastAPI) -> None:
    """Answer every error of the application with a problem document."""
    app.add_exception_handler(SurefixError, _answer_error)
    app.add_exception_handler(RequestValidationError, _answer_validation)
    app.add_exception_handler(HTTPException, _answer_http)
    app.add_exception_handler(OSError, _answer_os)
    app.add_exception_handler(Exception, _answer_defect)


def problem_of(error: SurefixError) -> Problem:
    """The entry of the error's class or of the nearest class above it; a defect where there is none."""
    return next((PROBLEMS[kind] for kind in type(error).__mro__ if kind in PROBLEMS), DEFECT)


def json_pointer(field: str) -> str:
    """`wifi[0].t` as the URI fragment of RFC 6901 that RFC 9457 shows: `#/wifi/0/t`."""
    parts = (found[1] or found[0] for found in _PATH_PART.finditer(field))
    return "#" + "".join("/" + part.replace("~", "~0").replace("/", "~1") for part in parts)


def headers_of(error: Exception) -> dict[str, str]:
    """What the answer to an error says in its header: how to send a key, or when to come again."""
    match error:
        case Unauthenticated():
            return {"WWW-Authenticate": 'Bearer realm="surefix"'}
        case Forbidden():
            return {"WWW-Authenticate": 'Bearer realm="surefix", error="insufficient_scope"'}
        case DependencyDown(retry_after_s=seconds):
            return {"Retry-After": str(seconds)}
    return {}


def problem_document(error: Exception) -> dict[str, Any]:
    """What an error of work that goes on without its request is told as; a field is one of the body."""
    error = told_as(error)
    problem = problem_of(error) if isinstance(error, SurefixError) else DEFECT
    if problem is DEFECT:
        return _members(DEFECT, DEFECT_DETAIL, {})
    field = error.field if isinstance(error, InvalidInput | NotFound) else ""
    return _members(problem, str(error), _place(field, in_body=True) if field else {})


async def _answer_error(request: Request, error: Exception) -> Response:
    assert isinstance(error, SurefixError)  # what the handler is registered for
    problem = problem_of(error)
    if problem is DEFECT:
        raise error
    members: dict[str, Any] = {}
    match error:
        case InvalidInput(field=field) | NotFound(field=field) if field:
            members = _place(field, _is_of_body(request, field))
        case DependencyDown():
            _log.warning("%s %s: %s", request.method, _route(request), error)
    return _document(problem, str(error), members, headers_of(error))


async def _answer_os(request: Request, error: Exception) -> Response:
    """A disk that is full is no defect: what comes is told to come again."""
    told = told_as(error)
    if told is error:
        raise error
    return await _answer_error(request, told)


async def _answer_validation(request: Request, error: Exception) -> Response:
    """What FastAPI found in a query, a path or a body: the first finding, and all of them as `errors`."""
    assert isinstance(error, RequestValidationError)
    findings = [_finding(found) for found in error.errors()[:MOST_ERRORS]]
    first = findings[0] if findings else {"detail": "the request cannot be used"}
    return _document(PROBLEMS[InvalidInput], first["detail"], {**first, "errors": findings})


async def _answer_http(request: Request, error: Exception) -> Response:
    """Starlette's own refusals: unknown routes and methods, damaged forms."""
    assert isinstance(error, HTTPException)
    title = http.HTTPStatus(error.status_code).phrase
    name = "not-found" if error.status_code == http.HTTPStatus.NOT_FOUND else title.lower().replace(" ", "-")
    detail = str(error.detail)
    if error.status_code in (http.HTTPStatus.NOT_FOUND, http.HTTPStatus.METHOD_NOT_ALLOWED) and detail == title:
        detail = f"{request.method} {request.url.path[:200]} is not part of this service; /docs lists what is"
    return _document(Problem(error.status_code, name, title), detail, headers=error.headers)


async def _answer_defect(request: Request, error: Exception) -> Response:
    """Nothing of the inside leaves. Starlette raises the error again afterwards, so the server logs its trace."""
    _log.error("%s %s failed: %s", request.method, _route(request), type(error).__name__)
    return _document(DEFECT, DEFECT_DETAIL)


def _route(request: Request) -> str:
    """The path without what was filled in: the id of a session is its phone's secret."""
    return str(getattr(request.scope.get("route"), "path", "(no route)"))


def _finding(found: Mapping[str, Any]) -> dict[str, Any]:
    where, *parts = found["loc"] or ("body",)
    if found["type"] == "json_invalid":
        parts = []  # pydantic puts the position of the character there
    field = field_path(parts)
    place = _place(field, in_body=where == "body") if field else {}
    return {"detail": str(found["msg"]), **place}


def _is_of_body(request: Request, field: str) -> bool:
    """Whether a field that a service names came with the body, rather than the path or the query."""
    return request.method in _WITH_BODY and field not in request.path_params and field not in request.query_params


def _place(field: str, in_body: bool) -> dict[str, str]:
    field = field[:LONGEST_FIELD]
    return {"field": field, "pointer": json_pointer(field)} if in_body else {"field": field}


def _document(
    problem: Problem, detail: str, members: Mapping[str, Any] | None = None, headers: Mapping[str, str] | None = None
) -> Response:
    # ASCII: what a client sent may hold half a surrogate pair, which UTF-8 cannot
    body = json.dumps(_members(problem, detail, members or {})).encode()
    return Response(body, problem.status, headers, media_type=MEDIA_TYPE)


def _members(problem: Problem, detail: str, more: Mapping[str, Any]) -> dict[str, Any]:
    return {"type": TYPE + problem.name, "title": problem.title, "status": problem.status, **more, "detail": detail}
