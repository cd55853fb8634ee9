"""Hot session states: what saves reading and decoding a state that was just written.

A cache and nothing more. The database holds every state beside the sequence it belongs to; an entry counts only if its
sequence is the database's, so one that is stale, lost or another worker's can do no harm.
"""

from __future__ import annotations

import logging
from collections import OrderedDict
from collections.abc import Callable
from typing import Any, Protocol

from redis.asyncio import Redis
from redis.asyncio.retry import Retry
from redis.backoff import NoBackoff
from redis.exceptions import RedisError

from app.errors import DependencyDown, InvalidInput

LARGEST_MEMORY = 10_000
"""States kept in memory; each is a few kilobytes."""
REDIS_PATIENCE_S = 2.0
_SEQUENCE_BYTES = 8
_log = logging.getLogger(__name__)


class HotStates(Protocol):
    """States by session, each with the sequence of the batch that it follows."""

    async def get(self, session: str, sequence: int) -> Any | None:
        """The state after that batch, or None where it is not held.

        Raises
        ------
        DependencyDown : the store cannot be reached.
        """
        ...

    async def put(self, session: str, sequence: int, state: Any, encoded: bytes) -> None:
        """Keep a state that the database has. Never fails: what is not kept is read from there."""
        ...

    async def discard(self, session: str) -> None:
        """Forget a session. Raises as get does."""
        ...

    async def ping(self) -> None:
        """Raises as get does."""
        ...

    async def close(self) -> None:
        """Give connections back."""
        ...


class MemoryStates:
    """In this process: the most recently used sessions."""

    def __init__(self, largest: int = LARGEST_MEMORY) -> None:
        self._largest = largest
        self._states: OrderedDict[str, tuple[int, Any]] = OrderedDict()

    async def get(self, session: str, sequence: int) -> Any | None:
        held = self._states.get(session)
        if held is None or held[0] != sequence:
            return None
        self._states.move_to_end(session)
        return held[1]

    async def put(self, session: str, sequence: int, state: Any, encoded: bytes) -> None:
        self._states[session] = (sequence, state)
        self._states.move_to_end(session)
        if len(self._states) > self._largest:
            self._states.popitem(last=False)

    async def discard(self, session: str) -> None:
        self._states.pop(session, None)

    async def ping(self) -> None:
        return

    async def close(self) -> None:
        self._states.clear()


class RedisStates:
    """In Redis: shared by all workers and forgotten there after lifetime_s.

    Parameters
    ----------
    decode : what turns an encoded state back; the inverse of what made `encoded`.
    """

    def __init__(self, client: Redis, decode: Callable[[bytes], Any], lifetime_s: float) -> None:
        self._client = client
        self._decode = decode
        self._lifetime_s = max(round(lifetime_s), 1)

    async def get(self, session: str, sequence: int) -> Any | None:
        try:
            held = await self._client.get(_key(session))
        except (RedisError, OSError) as error:
            raise _down(error) from error
        if not isinstance(held, bytes) or held[:_SEQUENCE_BYTES] != _prefix(sequence):
            return None
        return self._decode(held[_SEQUENCE_BYTES:])

    async def put(self, session: str, sequence: int, state: Any, encoded: bytes) -> None:
        try:
            await self._client.set(_key(session), _prefix(sequence) + encoded, ex=self._lifetime_s)
        except (RedisError, OSError) as error:
            _log.warning("session state was not cached: %s", error)

    async def discard(self, session: str) -> None:
        try:
            await self._client.delete(_key(session))
        except (RedisError, OSError) as error:
            raise _down(error) from error

    async def ping(self) -> None:
        try:
            await self._client.ping()
        except (RedisError, OSError) as error:
            raise _down(error) from error

    async def close(self) -> None:
        await self._client.aclose()


def hot_states(url: str, decode: Callable[[bytes], Any], lifetime_s: float) -> HotStates:
    """The store that a setting names: `memory` or `redis://host:port/db`. Connects at first use.

    Raises
    ------
    InvalidInput : names neither.
    """
    if url == "memory":
        return MemoryStates()
    if url.startswith(("redis://", "rediss://", "unix://")):
        try:
            client = Redis.from_url(
                url,
                socket_timeout=REDIS_PATIENCE_S,
                socket_connect_timeout=REDIS_PATIENCE_S,
                retry=Retry(
                    NoBackoff(), 1
                ),  # a connection from before a restart is replaced, an outage is told at once
            )
        except ValueError as error:
            raise InvalidInput(f"not a Redis address: {error}", "sessions") from error
        return RedisStates(client, decode, lifetime_s)
    raise InvalidInput("session state lives in `memory` or at redis://host:port/db", "sessions")


def _key(session: str) -> str:
    return f"surefix:state:{session}"


def _prefix(sequence: int) -> bytes:
    return sequence.to_bytes(_SEQUENCE_BYTES, "big", signed=True)


def _down(error: Exception) -> DependencyDown:
    return DependencyDown(f"the session store cannot be reached: {type(error).__name__}")
