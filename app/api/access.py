"""The dependency that lets only requests with the right key pass."""

from __future__ import annotations

from typing import Any
from urllib.parse import urlsplit

from fastapi import Request, Security
from fastapi.security import APIKeyQuery, HTTPBearer

from app.services.access import Access, Scope, is_loopback

_BEARER = HTTPBearer(scheme_name="key", description="`Authorization: Bearer <key>`", auto_error=False)
_QUERY = APIKeyQuery(name="key", scheme_name="keyInQuery", description="as existing clients send it", auto_error=False)


class Gate:
    """Passes requests whose key has one of the scopes; a dependency, and a function of the request.

    Raises Unauthenticated, Forbidden or DependencyDown as Access does.
    """

    def __init__(self, access: Access, *scopes: Scope) -> None:
        self._access = access
        self._scopes = scopes

    async def __call__(self, request: Request, _bearer: Any = Security(_BEARER)) -> None:
        await self._access.require(bearer_key(request), *self._scopes, local=is_local(request))


class QueryGate(Gate):
    """A Gate that also takes the key from `?key=`."""

    async def __call__(
        self, request: Request, _bearer: Any = Security(_BEARER), _query: Any = Security(_QUERY)
    ) -> None:
        key = bearer_key(request) or request.query_params.get("key")
        await self._access.require(key, *self._scopes, local=is_local(request))


def bearer_key(request: Request) -> str | None:
    """The key of the Authorization header, or None where there is none."""
    scheme, _, key = request.headers.get("authorization", "").partition(" ")
    return key.strip() if scheme.lower() == "bearer" else None


def is_local(request: Request) -> bool:
    """Whether a request was made for this machine by name, and by no web page of another one.

    A browser sends requests to loopback for any page that asks it to: with that page's `Origin`, or, where the page's
    own name was pointed at 127.0.0.1 (DNS rebinding), with that name as `Host`. Programs send no `Origin`.
    """
    host, origin = request.headers.get("host"), request.headers.get("origin")
    return (host is None or _names_loopback(f"//{host}")) and (origin is None or _names_loopback(origin))


def _names_loopback(address: str) -> bool:
    try:
        return is_loopback(urlsplit(address).hostname or "")
    except ValueError:
        return False
