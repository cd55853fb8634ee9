from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

import pytest
from fastapi import FastAPI, HTTPException
from fastapi.testclient import TestClient
from hypothesis import given
from hypothesis import strategies as st

from app.api.phones import phones_router
from app.services.phones import LIVE_S, NewestFix, public_number

SESSION = "6d1f3f0e9a7b4c52"


class Listed:
    """Fixes in a list: the reader without a database."""

    def __init__(self, fixes: Sequence[NewestFix]) -> None:
        self.fixes = fixes

    async def newest_fixes(self, venue: str, since_s: float) -> Sequence[NewestFix]:
        return [one for one in self.fixes if one.received_s >= since_s]


def _client(fixes: Sequence[NewestFix], allowed: bool = True) -> TestClient:
    def admin() -> None:
        if not allowed:
            raise HTTPException(403)

    app = FastAPI()
    app.include_router(phones_router(lambda: Listed(fixes), admin))
    return TestClient(app)


def _fix(session: str, age_s: float, **fix: Any) -> NewestFix:
    return NewestFix(session, time.time() - age_s, {"session": session, "t": 1, "position": None, **fix})


def test_phones_are_listed_with_their_newest_fix_and_without_their_session() -> None:
    answer = _client([_fix(SESSION, 3.0, accuracy=2.5)]).get("/v1/venues/mall/phones")
    (phone,) = answer.json()["phones"]
    assert SESSION not in answer.text
    assert phone["phone"] == public_number(SESSION)
    assert phone["age"] == pytest.approx(3.0, abs=1.0)
    assert phone["fix"] == {"t": 1, "position": None, "accuracy": 2.5}


def test_phones_that_have_been_silent_are_not_listed() -> None:
    client = _client([_fix("gone", LIVE_S + 5.0), _fix("here", LIVE_S - 5.0)])
    assert [phone["phone"] for phone in client.get("/v1/venues/mall/phones").json()["phones"]] == [
        public_number("here")
    ]


def test_only_an_administrator_may_list() -> None:
    assert _client([], allowed=False).get("/v1/venues/mall/phones").status_code == 403


@given(st.text(min_size=1), st.text(min_size=1))
def test_a_phone_keeps_its_number_and_two_have_two(one: str, other: str) -> None:
    assert public_number(one) == public_number(one)
    assert (public_number(one) == public_number(other)) == (one == other)
