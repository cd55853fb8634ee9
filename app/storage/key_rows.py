"""API keys in the database: their digests, never the keys."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from sqlalchemy import bindparam, insert, select, update
from sqlalchemy.ext.asyncio import AsyncEngine

from app.storage.database import reachable
from app.storage.tables import api_keys


@dataclass(frozen=True, slots=True)
class KeyRow:
    """A key without what makes it one. Times are Unix ms of the server's clock."""

    id: int
    name: str
    scopes: tuple[str, ...]
    created_ms: int
    revoked_ms: int | None


class KeyRows:
    """Reads and writes keys. Each method raises DependencyDown where the database cannot be reached."""

    def __init__(self, engine: AsyncEngine) -> None:
        self._engine = engine

    async def scopes(self, digest: bytes) -> frozenset[str] | None:
        """The scopes of a key that is not revoked; None if there is none."""
        async with reachable(), self._engine.connect() as connection:
            row = (await connection.execute(_READ_SCOPES, {"of": digest})).one_or_none()
        return None if row is None else frozenset(row.scopes)

    async def exist(self) -> bool:
        """Whether a key was ever made; revoked ones count."""
        async with reachable(), self._engine.connect() as connection:
            return await connection.scalar(_READ_ONE) is not None

    async def add(self, name: str, digest: bytes, scopes: Iterable[str], created_ms: int) -> int:
        """Store a new key; gives its id."""
        values = {"name": name, "digest": digest, "scopes": sorted(scopes), "created_ms": created_ms}
        async with reachable(), self._engine.begin() as connection:
            key = await connection.scalar(insert(api_keys).values(values).returning(api_keys.c.id))
        return int(key or 0)

    async def listed(self) -> list[KeyRow]:
        """Every key, oldest first."""
        async with reachable(), self._engine.connect() as connection:
            rows = (await connection.execute(select(api_keys).order_by(api_keys.c.id))).all()
        return [KeyRow(row.id, row.name, tuple(row.scopes), row.created_ms, row.revoked_ms) for row in rows]

    async def revoke(self, key: int, now_ms: int) -> bool:
        """End a key for good; False if there is none that is valid."""
        query = update(api_keys).where(api_keys.c.id == key, api_keys.c.revoked_ms.is_(None)).values(revoked_ms=now_ms)
        async with reachable(), self._engine.begin() as connection:
            return (await connection.execute(query)).rowcount == 1


_READ_SCOPES = select(api_keys.c.scopes).where(api_keys.c.digest == bindparam("of"), api_keys.c.revoked_ms.is_(None))
_READ_ONE = select(api_keys.c.id).limit(1)
