from __future__ import annotations

import asyncio

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import Forbidden, Unauthenticated
from app.services.access import LARGEST, PREFIX, REMEMBER_S, Access, Scope, is_loopback, key_digest, new_key


class Keys:
    """Keys in a dictionary, and how often they were asked for."""

    def __init__(self, **scopes: set[str]) -> None:
        self.stored = {key_digest(key): frozenset(granted) for key, granted in scopes.items()}
        self.ever = bool(scopes)
        self.asked = 0

    async def scopes(self, digest: bytes) -> frozenset[str] | None:
        self.asked += 1
        return self.stored.get(digest)

    async def exist(self) -> bool:
        self.asked += 1
        return self.ever


def required(access: Access, key: str | None, *scopes: Scope) -> None:
    asyncio.run(access.require(key, *scopes))


def test_a_key_is_good_for_its_scopes_alone() -> None:
    access = Access(Keys(phone={"position"}, all={"position", "survey", "admin"}), open_without_keys=False)
    required(access, "phone", Scope.POSITION)
    required(access, "phone", Scope.SURVEY, Scope.POSITION)
    required(access, "all", Scope.ADMIN)
    with pytest.raises(Forbidden, match="admin"):
        required(access, "phone", Scope.ADMIN)


@pytest.mark.parametrize("key", [None, "", "other", "PHONE", "phone ", "é" * 50, "\ud800", "k" * 100_000])
def test_without_a_known_key_nobody_passes(key: str | None) -> None:
    access = Access(Keys(phone={"position"}), open_without_keys=False)
    with pytest.raises(Unauthenticated):
        required(access, key, Scope.POSITION)


def test_while_no_key_was_ever_made_a_service_on_loopback_is_open_and_any_other_is_not() -> None:
    required(Access(Keys(), open_without_keys=True), None, Scope.ADMIN)
    required(Access(Keys(), open_without_keys=True), "left over", Scope.ADMIN)
    with pytest.raises(Unauthenticated):
        required(Access(Keys(), open_without_keys=False), None, Scope.ADMIN)


def test_once_a_key_is_made_keys_are_required_within_the_time_that_is_stated_and_for_good() -> None:
    keys, now_s = Keys(), [100.0]
    access = Access(keys, open_without_keys=True, clock_s=lambda: now_s[0])
    required(access, None, Scope.POSITION)
    keys.ever = True
    now_s[0] += REMEMBER_S
    with pytest.raises(Unauthenticated):
        required(access, None, Scope.POSITION)
    keys.ever = False
    with pytest.raises(Unauthenticated):
        required(access, None, Scope.POSITION)


def test_a_key_is_looked_up_once_in_a_while_and_ends_within_that_after_it_is_revoked() -> None:
    keys, now_s = Keys(phone={"position"}), [100.0]
    access = Access(keys, open_without_keys=False, clock_s=lambda: now_s[0])
    for _ in range(50):
        required(access, "phone", Scope.POSITION)
    assert keys.asked == 1
    keys.stored.clear()
    now_s[0] += REMEMBER_S
    with pytest.raises(Unauthenticated):
        required(access, "phone", Scope.POSITION)


def test_what_is_remembered_is_bounded_and_unknown_keys_do_not_push_out_known_ones() -> None:
    keys = Keys(phone={"position"})
    access = Access(keys, open_without_keys=False)
    required(access, "phone", Scope.POSITION)

    async def guess() -> None:
        for n in range(LARGEST + 10):
            with pytest.raises(Unauthenticated):
                await access.require(f"guess {n}", Scope.POSITION)

    asyncio.run(guess())
    asked = keys.asked
    required(access, "phone", Scope.POSITION)
    assert keys.asked == asked


def test_keys_are_long_recognisable_and_never_the_same() -> None:
    made = {new_key() for _ in range(100)}
    assert len(made) == 100
    assert all(key.startswith(PREFIX) and len(key) >= len(PREFIX) + 43 for key in made)


@given(st.text(), st.text())
def test_two_keys_have_two_digests(one: str, other: str) -> None:
    assert (key_digest(one) == key_digest(other)) == (one == other)


@pytest.mark.parametrize(
    ("host", "loopback"),
    [
        ("127.0.0.1", True),
        ("127.8.0.1", True),
        ("::1", True),
        ("localhost", True),
        ("0.0.0.0", False),
        ("::", False),
        ("192.168.1.5", False),
        ("example.org", False),
        ("localhost.example.org", False),
        ("", False),
    ],
)
def test_loopback_is_what_only_this_machine_reaches(host: str, loopback: bool) -> None:
    assert is_loopback(host) is loopback
