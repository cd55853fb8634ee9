from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import orjson
from fastapi import FastAPI, HTTPException
from fastapi.testclient import TestClient
from hypothesis import given
from hypothesis import strategies as st

from app.api.phones import phones_router
from app.api.problems import install_problems
from app.services.phones import LIVE_MS, Phones, public_number
from app.storage.phone_rows import PhoneRow

SESSION = "6d1f3f0e9a7b4c52"
NOW_MS = 1_700_000_000_000


class Listed:
    """Fixes in a list: one venue, `mall`, without a database."""

    def __init__(self, rows: Sequence[PhoneRow]) -> None:
        self.rows = rows

    async def newest(self, venue: str, since_ms: int) -> list[PhoneRow] | None:
        return [row for row in self.rows if row.received_ms >= since_ms] if venue == "mall" else None


def _client(rows: Sequence[PhoneRow], allowed: bool = True) -> TestClient:
    def admin() -> None:
        if not allowed:
            raise HTTPException(403)

    phones = Phones(Listed(rows), lambda: NOW_MS)  # type: ignore[arg-type]
    app = FastAPI()
    install_problems(app)
    app.include_router(phones_router(lambda: phones, admin))
    return TestClient(app)


def _row(session: str, age_ms: int, **fix: Any) -> PhoneRow:
    return PhoneRow(session, NOW_MS - age_ms, orjson.dumps({"session": session, "t": 1, "position": None, **fix}))


def test_phones_are_listed_with_their_newest_fix_and_without_their_session() -> None:
    answer = _client([_row(SESSION, 3250, accuracy=2.5)]).get("/v1/venues/mall/phones")
    (phone,) = answer.json()["phones"]
    assert SESSION not in answer.text
    assert phone["phone"] == public_number(SESSION)
    assert phone["age"] == 3.25
    assert phone["fix"] == {"t": 1, "position": None, "accuracy": 2.5}


def test_phones_that_have_been_silent_are_not_listed() -> None:
    client = _client([_row("gone", LIVE_MS + 1), _row("here", LIVE_MS)])
    assert [phone["phone"] for phone in client.get("/v1/venues/mall/phones").json()["phones"]] == [
        public_number("here")
    ]


def test_a_venue_that_is_not_there_is_not_found() -> None:
    assert _client([]).get("/v1/venues/nowhere/phones").status_code == 404


def test_only_an_administrator_may_list() -> None:
    assert _client([], allowed=False).get("/v1/venues/mall/phones").status_code == 403


@given(st.text(min_size=1), st.text(min_size=1))
def test_a_phone_keeps_its_number_and_two_have_two(one: str, other: str) -> None:
    assert public_number(one) == public_number(one)
    assert (public_number(one) == public_number(other)) == (one == other)
