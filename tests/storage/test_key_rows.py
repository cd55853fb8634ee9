from __future__ import annotations

from sqlalchemy.ext.asyncio import AsyncEngine

from app.services.access import key_digest
from app.storage.key_rows import KeyRow, KeyRows
from tests.storage.conftest import Run


def test_a_key_is_found_by_its_digest_until_it_is_revoked(run: Run) -> None:
    async def use(engine: AsyncEngine) -> None:
        rows = KeyRows(engine)
        digest = key_digest("secret")
        assert await rows.exist() is False
        key = await rows.add("phones", digest, {"survey", "position"}, 5)
        assert await rows.scopes(digest) == frozenset({"position", "survey"})
        assert await rows.scopes(key_digest("other")) is None
        assert await rows.revoke(key, 9) is True
        assert await rows.revoke(key, 10) is False
        assert await rows.scopes(digest) is None
        assert await rows.exist() is True
        assert await rows.listed() == [KeyRow(key, "phones", ("position", "survey"), 5, 9)]

    run(use)
