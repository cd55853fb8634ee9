"""A venue where nothing but Bluetooth beacons was surveyed, from the survey to a phone's position, over HTTP."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import pytest
from fastapi.testclient import TestClient

from tests.api.whole_service import whole_service

UUID = "9195b3ad-a9d0-4500-85ff-9fb0f65a5201"
T0 = 1_700_000_000_000
WIDTH_M, HEIGHT_M = 24.0, 12.0
BEACONS = [(x, y) for x in (2.0, 8.0, 16.0, 22.0) for y in (2.0, 10.0)]


def heard_at(x: float, y: float) -> list[dict[str, Any]]:
    """What a phone reports there, the strongest first."""
    readings = []
    for minor, (a, b) in enumerate(BEACONS):
        rssi = -55.0 - 25.0 * math.log10(max(math.hypot(x - a, y - b), 0.5))
        if rssi > -85.0:
            readings.append({"id": f"{UUID}:1:{minor}", "rssi": round(rssi), "tx_power": -59})
    return sorted(readings, key=lambda one: -one["rssi"])


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with whole_service(tmp_path_factory.mktemp("beacons")) as made:
        assert made.post("/v1/venues", json={"venue": "garage", "name": "Garage"}).status_code == 201
        floor = {"name": "B1", "level": -1, "width": WIDTH_M, "height": HEIGHT_M}
        assert made.put("/v1/venues/garage/floors/B1", json=floor).status_code == 201
        places = [(2.0 * i, 2.0 * j) for i in range(13) for j in range(7)]
        survey = {
            "floor": "B1",
            "fingerprints": [{"x": x, "y": y, "t": T0, "readings": [], "bluetooth": heard_at(x, y)} for x, y in places],
        }
        answer = made.post("/v1/venues/garage/surveys?publish=true", json=survey)
        assert answer.status_code == 201, answer.text
        assert (answer.json()["accepted"], answer.json()["rejected"]) == (len(places), [])
        yield made


def session(service: TestClient) -> str:
    return str(service.post("/v1/sessions", json={"venue": "garage"}).json()["session"])


def sent(service: TestClient, phone: str, sequence: int, scans: list[dict[str, Any]]) -> dict[str, Any]:
    body = {"sequence": sequence, "end": T0 + 2000 * (sequence + 1), "bluetooth": scans}
    answer = service.post(f"/v1/sessions/{phone}/batches", json=body)
    assert answer.status_code == 200, answer.text
    return dict(answer.json())


def test_the_published_map_counts_its_beacons(service: TestClient) -> None:
    (version,) = service.get("/v1/venues/garage/radio-maps").json()["radio_maps"]
    assert version["active"] and version["summary"]["beacons"] == len(BEACONS)
    assert version["summary"]["access_points"] == 0


@pytest.mark.parametrize("place", [(5.0, 3.0), (12.0, 6.0), (20.0, 9.0)])
def test_scans_of_beacons_locate_a_phone(service: TestClient, place: tuple[float, float]) -> None:
    phone = session(service)
    for sequence in range(3):
        fix = sent(service, phone, sequence, [{"t": T0 + 2000 * sequence + 1500, "readings": heard_at(*place)}])
    assert fix["position"]["floor"] == "B1"
    assert math.dist((fix["position"]["x"], fix["position"]["y"]), place) < 3.0
    assert fix["integrity"]["flag"] in ("nominal", "corrected")
    assert fix["accuracy"] > 0.0 and fix["integrity"]["protection_level"] > fix["accuracy"]


def test_readings_that_are_reported_one_by_one_locate_it_as_well(service: TestClient) -> None:
    phone, place = session(service), (8.0, 5.0)
    heard = heard_at(*place)
    for sequence in range(4):
        at = [T0 + 2000 * sequence + 200 * (n + 1) for n in range(len(heard))]
        fix = sent(service, phone, sequence, [{"t": t, "readings": [one]} for t, one in zip(at, heard, strict=True)])
    assert math.dist((fix["position"]["x"], fix["position"]["y"]), place) < 4.0


def test_beacons_of_somebody_else_locate_nobody(service: TestClient) -> None:
    phone = session(service)
    fix = sent(service, phone, 0, [{"t": T0, "readings": [{"id": f"{UUID}:2:1", "rssi": -60}]}])
    assert fix["position"] is None and fix["integrity"]["flag"] == "initialising"


def test_a_phone_whose_beacons_fall_silent_is_coasting(service: TestClient) -> None:
    phone = session(service)
    sent(service, phone, 0, [{"t": T0 + 1000, "readings": heard_at(5.0, 3.0)}])
    flags = [sent(service, phone, sequence, [])["integrity"]["flag"] for sequence in range(1, 8)]
    assert flags[0] == "nominal" and flags[-1] == "coasting"
