from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.fusion.interface import Site
from app.fusion.methods import METHODS
from app.observations import Batch
from app.wifi.bssid import format_bssid
from tests.api.whole_service import whole_service
from tests.odometer import FAULT_BSSID, ODOMETER, Odometer

LIST = "/v1/venues/mall/radio-maps/1/watch-list"
MOVED = format_bssid(FAULT_BSSID)
OTHER = "a8:0c:ca:03:9d:d7"
T0 = 1_573_190_000_000
seen: list[frozenset[int]] = []
"""What the method was told is watched, batch by batch."""


def _advance(state: Odometer, batch: Batch, site: Site) -> Any:
    seen.append(site.watched)
    return ODOMETER.advance(state, batch, site)


@pytest.fixture
def client(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[TestClient]:
    """The service with a surveyed venue, and a method that excludes MOVED wherever it hears it."""
    monkeypatch.setitem(METHODS, "odometer", dataclasses.replace(ODOMETER, advance=_advance))
    seen.clear()
    with whole_service(tmp_path) as made:
        made.post("/v1/venues", json={"venue": "mall"})
        made.put("/v1/venues/mall/floors/F1", json={"level": 0, "width": 100.0, "height": 60.0})
        readings = [{"bssid": OTHER, "rssi": -50}, {"bssid": MOVED, "rssi": -60}]
        fingerprints = [{"x": 5.0 * n, "y": 10.0, "t": T0, "readings": readings} for n in range(3)]
        survey = {"floor": "F1", "fingerprints": fingerprints}
        answer = made.post("/v1/venues/mall/surveys", params={"publish": "true"}, json=survey)
        assert answer.json()["version"] == 1, answer.text
        yield made


def opened(client: TestClient) -> str:
    answer = client.post("/v1/sessions", json={"venue": "mall", "method": "odometer"})
    return str(answer.json()["session"])


def send(client: TestClient, session: str, sequence: int, bssid: str = OTHER) -> None:
    scan = {"t": T0 + 1000 * sequence, "readings": [{"bssid": bssid, "rssi": -50}]}
    answer = client.post(f"/v1/sessions/{session}/batches", json={"sequence": sequence, "wifi": [scan]})
    assert answer.status_code == 200, answer.text


def test_what_three_sessions_exclude_is_watched_and_every_session_told_until_it_is_removed(client: TestClient) -> None:
    walking = opened(client)
    for number, session in enumerate([opened(client) for _ in range(3)]):
        assert client.get(LIST).json() == {"version": 1, "access_points": []}, number
        for sequence in range(3):
            send(client, session, sequence, MOVED)
    (entry,) = client.get(LIST).json()["access_points"]
    assert (entry["bssid"], entry["reason"], entry["evidence"], entry["state"]) == (MOVED, "moved", 3, "watched")
    assert entry["first_seen"] <= entry["last_seen"]

    send(client, walking, 0)
    assert seen[-1] == {FAULT_BSSID}
    assert client.delete(f"{LIST}/{MOVED}").status_code == 204
    assert client.delete(f"{LIST}/{MOVED}").status_code == 404
    send(client, walking, 1)
    assert seen[-1] == frozenset()
    assert client.get(LIST).json()["access_points"][0]["state"] == "removed"


def test_an_administrator_puts_access_points_on_the_list(client: TestClient) -> None:
    session = opened(client)
    answer = client.post(LIST, json={"bssid": OTHER.upper()})
    assert (answer.status_code, answer.json()["bssid"]) == (201, OTHER)
    assert (answer.json()["reason"], answer.json()["evidence"]) == ("by hand", 0)
    assert client.post(LIST, json={"bssid": OTHER, "reason": "again"}).status_code == 200
    send(client, session, 0)
    assert seen[-1] == {int(OTHER.replace(":", ""), 16)}


@pytest.mark.parametrize(
    "body", [{}, {"bssid": "a8:0c"}, {"bssid": OTHER, "reason": ""}, {"bssid": OTHER, "state": "permanent"}]
)
def test_what_is_no_access_point_is_refused(client: TestClient, body: dict[str, str]) -> None:
    assert client.post(LIST, json=body).status_code == 422


def test_a_version_that_does_not_exist_has_no_list(client: TestClient) -> None:
    for path in (LIST.replace("/1/", "/2/"), LIST.replace("mall", "none")):
        assert client.get(path).status_code == client.post(path, json={"bssid": OTHER}).status_code == 404
        assert client.delete(f"{path}/{OTHER}").status_code == 404
    assert client.get(LIST.replace("/1/", "/x/")).status_code == 422


def test_a_new_version_takes_the_list_over_until_what_is_on_it_is_surveyed_again(client: TestClient) -> None:
    for bssid in (OTHER, MOVED):
        client.post(LIST, json={"bssid": bssid})
    surveys = client.get("/v1/venues/mall/radio-maps").json()["radio_maps"][0]["surveys"]
    assert client.post("/v1/venues/mall/radio-maps", json={"surveys": surveys}).json()["version"] == 2
    client.put("/v1/venues/mall/radio-map", json={"version": 2})
    session = opened(client)
    send(client, session, 0)
    assert seen[-1] == {int(OTHER.replace(":", ""), 16), FAULT_BSSID}
    again = [{"x": 5.0, "y": 10.0, "t": T0, "readings": [{"bssid": OTHER, "rssi": -70}]}]
    answer = client.post("/v1/venues/mall/surveys?publish=true", json={"floor": "F1", "fingerprints": again})
    assert (answer.status_code, answer.json()["version"]) == (201, 3), answer.text
    send(client, session, 1)
    assert seen[-1] == {FAULT_BSSID}
