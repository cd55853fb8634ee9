from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.api.phone_service import PhoneService, phone_service
from tests.api.test_sessions import batch


@pytest.fixture
def service(tmp_path: Path) -> Iterator[PhoneService]:
    with phone_service(f"sqlite:///{tmp_path / 'phones.db'}") as made:
        yield made


def test_an_opened_session_says_what_it_is_and_when_it_ends(service: PhoneService) -> None:
    body = {
        "venue": "mall",
        "method": "odometer",
        "floor": "F2",
        "device": {"brand": "OPPO\0\0", "model": "PBCM10", "os": 9},
        "alert_limit": 12,
        "risk": 0.05,
        "start": {"x": 1, "y": 2.0, "floor": "F1"},
        "future": True,
    }
    answer = service.client.post("/v1/sessions", json=body)
    assert answer.status_code == 201
    opened = answer.json()
    assert set(opened) == {"session", "venue", "method", "created", "expires"}
    assert len(opened["session"]) == 32
    assert opened["expires"] - opened["created"] == 12 * 3_600_000
    fix = service.fix(opened["session"], batch(0))
    assert fix["integrity"]["alert_limit"] == 12 and fix["integrity"]["risk"] == 0.05
    assert fix["position"]["floor"] == "F2"


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"method": "magic"}, "method"),
        ({"floor": 1}, "floor"),
        ({"start": {"x": 0, "y": "0", "floor": "F1"}}, "start.y"),
        ({"start": {"x": 1e308, "y": 0, "floor": "F1"}}, "start.x"),
        ({"start": {"x": 120, "y": 0, "floor": "F1"}}, "start.x"),
        ({"start": {"x": 50, "y": -20, "floor": "F1"}}, "start.y"),
        ({"alert_limit": 0}, "alert_limit"),
        ({"alert_limit": 1e308}, "alert_limit"),
        ({"alert_limit": "10"}, "alert_limit"),
        ({"risk": 0.0005}, "risk"),
        ({"risk": 0.051}, "risk"),
        ({"device": {"brand": 5}}, "device.brand"),
        ({"venue": None}, "venue"),
    ],
)
def test_a_session_that_cannot_be_opened_is_refused_by_field(
    service: PhoneService, change: dict[str, Any], field: str
) -> None:
    answer = service.client.post("/v1/sessions", json={"venue": "mall", "method": "odometer", **change})
    assert answer.status_code == 422
    assert field in answer.text
    if field == "method":
        assert "odometer" in answer.text


@pytest.mark.parametrize(
    ("change", "pointer"),
    [({"floor": "F9"}, "#/floor"), ({"start": {"x": 0, "y": 0, "floor": "F9"}}, "#/start/floor")],
)
def test_an_unknown_floor_is_not_found_and_pointed_to(
    service: PhoneService, change: dict[str, Any], pointer: str
) -> None:
    answer = service.client.post("/v1/sessions", content=json.dumps({"venue": "mall", "method": "odometer", **change}))
    assert (answer.status_code, answer.json()["pointer"]) == (404, pointer)
    assert "F1, F2" in answer.json()["detail"]


@pytest.mark.parametrize("venue", ["other", "", "no such", "\0", "é", "m" * 64])
def test_an_unknown_venue_is_not_found(service: PhoneService, venue: str) -> None:
    assert service.client.post("/v1/sessions", json={"venue": venue}).status_code in (404, 422)
    assert service.client.post("/v1/sessions", json={"venue": venue, "method": "odometer"}).status_code == 404
