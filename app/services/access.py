"""Who may do what: API keys and their scopes."""

from __future__ import annotations

import hashlib
import ipaddress
import secrets
import time
from collections import OrderedDict
from collections.abc import Callable
from enum import StrEnum
from typing import Protocol

from app.errors import Forbidden, NotLocal, Unauthenticated

REMEMBER_S = 5.0
"""How long a verification is believed without asking the database: a revoked key works for at most so long."""
LARGEST = 10_000
"""Keys remembered at once."""
PREFIX = "surefix_"
LONGEST_KEY = 200


class Scope(StrEnum):
    """What a key may be good for."""

    POSITION = "position"
    SURVEY = "survey"
    ADMIN = "admin"


class KeyReader(Protocol):
    """What storage offers for it."""

    async def scopes(self, digest: bytes) -> frozenset[str] | None:
        """The scopes of a key that is not revoked; None if there is none."""
        ...

    async def exist(self) -> bool:
        """Whether a key was ever made; revoked ones count, so revoking the last does not open the service."""
        ...


def new_key() -> str:
    """A key that nobody can guess: 256 bits, behind a prefix by which a leaked one is recognised."""
    return PREFIX + secrets.token_urlsafe(32)


def key_digest(key: str) -> bytes:
    """What is stored of a key."""
    return hashlib.sha256(key.encode("utf-8", "surrogatepass")).digest()


def is_loopback(host: str) -> bool:
    """Whether an address to bind can be reached from this machine only."""
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


class Access:
    """Decides on keys, each looked up once in REMEMBER_S.

    Parameters
    ----------
    open_without_keys : this machine may do everything as long as no key was ever made; for a service on loopback.
    """

    def __init__(
        self, reader: KeyReader, open_without_keys: bool, clock_s: Callable[[], float] = time.monotonic
    ) -> None:
        self._reader = reader
        self._open_without_keys = open_without_keys
        self._clock_s = clock_s
        self._granted: OrderedDict[bytes, tuple[float, frozenset[str]]] = OrderedDict()
        self._no_keys_until_s = 0.0

    async def require(self, key: str | None, *scopes: Scope, local: bool = True) -> None:
        """Nothing, if the key has one of the scopes.

        Parameters
        ----------
        local : the request is this machine's own, as far as it says; others never pass without a key.

        Raises
        ------
        Unauthenticated : no key, or one that is unknown or revoked.
        Forbidden : a valid key without any of the scopes.
        NotLocal : while no key is needed, a request of another site.
        DependencyDown : the database cannot be reached.
        """
        if self._open_without_keys and await self._no_keys():
            if not local:
                raise NotLocal(
                    "without API keys this service answers its own machine only: Host, and Origin where there is one, "
                    "must name localhost, 127.0.0.1 or [::1]; to be called otherwise, make a key: `surefix key create`"
                )
            return
        if not key:
            raise Unauthenticated("an API key is needed: `Authorization: Bearer <key>`")
        granted = await self._scopes(key_digest(key)) if len(key) <= LONGEST_KEY else None
        if granted is None:
            raise Unauthenticated("the API key is unknown or revoked")
        if not granted.intersection(scopes):
            raise Forbidden(f"the API key needs scope {' or '.join(scopes)}; it has {', '.join(sorted(granted))}")

    async def _no_keys(self) -> bool:
        now_s = self._clock_s()
        if now_s < self._no_keys_until_s:
            return True
        if await self._reader.exist():
            self._open_without_keys = False  # once there is a key there is no way back
            return False
        self._no_keys_until_s = now_s + REMEMBER_S
        return True

    async def _scopes(self, digest: bytes) -> frozenset[str] | None:
        now_s = self._clock_s()
        held = self._granted.get(digest)
        if held is not None and now_s < held[0]:
            return held[1]
        scopes = await self._reader.scopes(digest)
        self._granted.pop(digest, None)
        if scopes is not None:  # unknown keys are not remembered: they would push out those in use
            self._granted[digest] = (now_s + REMEMBER_S, scopes)
            if len(self._granted) > LARGEST:
                self._granted.popitem(last=False)
        return scopes
