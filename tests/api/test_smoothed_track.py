"""`?smoothed=true`: the track as all evidence has it, of every method, over the whole path from batch to answer."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update

from app.fusion.methods import METHODS
from app.storage.tables import fixes
from tests.api.phone_service import PhoneService, phone_service
from tests.api.test_sessions import T0, batch
from tests.fusion.walks import Walked, site, walked

MOVED = {"position", "accuracy", "covariance", "heading", "integrity", "smoothed"}
WALK = walked(5, 60.0)


@pytest.fixture
def service(tmp_path: Path) -> Iterator[PhoneService]:
    url = f"sqlite:///{tmp_path / 'phones.db'}"
    with phone_service(url, site=site(), methods=METHODS) as made:
        yield made


def walk_through(service: PhoneService, session: str, walk: Walked = WALK) -> list[dict[str, Any]]:
    """The stored fixes of a walk, as answered."""
    for one in walk.batches:
        service.call(service.wired.tracking.advance, session, one)
    answer = service.client.get(f"/v1/sessions/{session}/track")
    return list(answer.json()["fixes"])


def smoothed_of(service: PhoneService, session: str, **params: Any) -> dict[str, Any]:
    answer = service.client.get(f"/v1/sessions/{session}/track", params={"smoothed": "true", **params})
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


@pytest.mark.parametrize("method", sorted(METHODS))
def test_every_method_has_a_smoothed_track(service: PhoneService, method: str) -> None:
    session = service.open(method=method)
    plain = walk_through(service, session)
    after = smoothed_of(service, session)["fixes"]
    assert [fix["sequence"] for fix in after] == [fix["sequence"] for fix in plain]
    placed = 0
    for fix, before in zip(after, plain, strict=True):
        assert fix["smoothed"] is True and "smoothed" not in before
        assert {name: fix[name] for name in set(fix) - MOVED} == {name: before[name] for name in set(before) - MOVED}
        assert (fix["position"] is None) == (before["position"] is None)
        if fix["position"] is not None:
            placed += 1
            assert 0.0 < fix["accuracy"] <= fix["integrity"]["protection_level"]
            assert fix["position"]["floor"] in site().floors
    assert placed > 20
    assert any(fix["position"] != before["position"] for fix, before in zip(after, plain, strict=True))


def test_pages_and_bounds_are_those_of_the_plain_track(service: PhoneService) -> None:
    session = service.open(method="surefix")
    plain = walk_through(service, session)
    whole = smoothed_of(service, session)["fixes"]
    pages, cursor = [], dict[str, str]()
    while True:
        page = smoothed_of(service, session, limit=20, **cursor)
        pages.append(page["fixes"])
        if page["next"] is None:
            break
        cursor = {"cursor": page["next"]}
    assert list(itertools.chain.from_iterable(pages)) == whole
    assert {len(page) for page in pages[:-1]} == {20}
    bounds = {"from": plain[5]["t"], "to": plain[9]["t"]}
    assert smoothed_of(service, session, **bounds)["fixes"] == whole[5:10]


def test_what_comes_later_moves_what_was_before(service: PhoneService) -> None:
    session = service.open(method="surefix")
    walk_through(service, session)
    early = smoothed_of(service, session, limit=20)["fixes"]
    other = service.open(method="surefix")
    for one in WALK.batches[:21]:
        service.call(service.wired.tracking.advance, other, one)
    running = smoothed_of(service, other)["fixes"][:20]
    assert [fix["t"] for fix in early] == [fix["t"] for fix in running]
    assert early[15]["position"] != running[15]["position"]
    assert early[15]["accuracy"] < running[15]["accuracy"]


def test_reading_it_changes_nothing(service: PhoneService) -> None:
    session = service.open(method="surefix")
    before = walk_through(service, session)
    smoothed_of(service, session)
    assert service.client.get(f"/v1/sessions/{session}/track").json()["fixes"] == before


def test_as_geojson_it_is_marked_and_has_the_smoothed_places(service: PhoneService) -> None:
    session = service.open(method="surefix")
    walk_through(service, session)
    answer = service.client.get(
        f"/v1/sessions/{session}/track?smoothed=true", headers={"Accept": "application/geo+json"}
    )
    assert answer.headers["Content-Type"] == "application/geo+json"
    features = answer.json()["features"]
    accuracy = [fix["accuracy"] for fix in smoothed_of(service, session)["fixes"]]
    assert [feature["properties"]["accuracy"] for feature in features] == accuracy
    assert all(feature["properties"]["smoothed"] is True for feature in features)


def test_fixes_without_evidence_stay_as_they_are(service: PhoneService) -> None:
    session = service.open(method="surefix")
    plain = walk_through(service, session)

    async def forget() -> None:
        async with service.wired.engine.begin() as connection:
            await connection.execute(update(fixes).where(fixes.c.sequence < 30).values(evidence=None))

    service.call(forget)
    after = smoothed_of(service, session)["fixes"]
    assert after[:30] == [{**fix, "smoothed": True} for fix in plain[:30]]
    assert all(fix["position"] != before["position"] for fix, before in zip(after[30:], plain[30:], strict=True))


def test_of_a_method_that_tells_nothing_but_its_fixes_they_stay(service: PhoneService) -> None:
    session = service.open(floor="F1")
    plain = [service.fix(session, batch(sequence)) for sequence in range(12)]
    assert smoothed_of(service, session)["fixes"] == [{**fix, "smoothed": True} for fix in plain]


def test_before_anything_is_known_it_is_empty_or_says_so(service: PhoneService) -> None:
    session = service.open(method="surefix")
    assert smoothed_of(service, session)["fixes"] == []
    service.fix(session, {"sequence": 0})
    service.fix(session, {"sequence": 1, "end": T0})
    after = smoothed_of(service, session)["fixes"]
    assert [(fix["position"], fix["smoothed"]) for fix in after] == [(None, True)] * 2


def test_an_erased_session_has_none(service: PhoneService) -> None:
    session = service.open(method="surefix")
    service.client.delete(f"/v1/sessions/{session}")
    assert service.client.get(f"/v1/sessions/{session}/track?smoothed=true").status_code == 404


def test_the_places_are_better_than_those_at_the_time(service: PhoneService) -> None:
    session = service.open(method="surefix")
    plain, after = walk_through(service, session), smoothed_of(service, session)["fixes"]

    def error_m(found: list[dict[str, Any]]) -> float:
        errors = []
        for fix in found:
            if fix["position"] is not None:
                truth = WALK.truth(fix["t"] / 1000.0)
                errors.append(((fix["position"]["x"] - truth[0]) ** 2 + (fix["position"]["y"] - truth[1]) ** 2) ** 0.5)
        return float(sum(errors) / len(errors))

    assert error_m(after) < error_m(plain)
