from __future__ import annotations

import gzip
import io
import json
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from PIL import Image

from app.api.problems import MEDIA_TYPE
from tests.api.whole_service import whole_service
from tests.open_data import open_data

RING = [[120.0, 30.0], [120.001, 30.0], [120.001, 30.001], [120.0, 30.0]]
PLAN = {
    "type": "FeatureCollection",
    "features": [
        {"type": "Feature", "properties": {"name": "room"}, "geometry": {"type": "Polygon", "coordinates": [RING]}}
    ],
}
PLACE = {"latitude": 30.0, "longitude": 120.0, "rotation": 0.5}
NUMBERS = count()
FLOOR: dict[str, Any] = {"name": "Ground", "level": 0, "width": 96.5, "height": 111}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with whole_service(tmp_path_factory.mktemp("venues")) as made:
        yield made


@pytest.fixture
def venue(client: TestClient) -> str:
    """A venue of the test's own."""
    name = f"v{next(NUMBERS)}"
    assert client.post("/v1/venues", json={"venue": name, "name": "Mall"}).status_code == 201
    return f"/v1/venues/{name}"


def png(width: int = 8) -> bytes:
    buffer = io.BytesIO()
    Image.new("L", (width, 4)).save(buffer, "PNG")
    return buffer.getvalue()


def everything(client: TestClient, venue: str) -> list[Any]:
    """What can be read of a venue."""
    floors = client.get(venue).json()["floors"]
    return [floors, *(client.get(f"{venue}/floors/{floor['floor']}").json() for floor in floors)]


def test_a_new_venue_is_listed_and_read(client: TestClient) -> None:
    made = client.post("/v1/venues", json={"venue": "A.b_c-9", "name": "Café 😀"})
    assert made.status_code == 201
    assert made.headers["location"] == "/v1/venues/A.b_c-9"
    document = made.json()
    assert (document["venue"], document["name"], document["version"], document["floors"]) == (
        "A.b_c-9",
        "Café 😀",
        None,
        [],
    )
    assert client.get("/v1/venues/A.b_c-9").json() == document
    assert "A.b_c-9" in [one["venue"] for one in client.get("/v1/venues").json()["venues"]]
    assert client.post("/v1/venues", json={"venue": "unnamed"}).json()["name"] == "unnamed"


def test_an_identifier_that_is_taken_is_a_conflict_and_changes_nothing(client: TestClient, venue: str) -> None:
    again = client.post("/v1/venues", json={"venue": venue.rpartition("/")[2], "name": "Other"})
    assert again.status_code == 409
    assert client.get(venue).json()["name"] == "Mall"


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({}, "venue"),
        ({"venue": None}, "venue"),
        ({"venue": 5}, "venue"),
        ({"venue": ""}, "venue"),
        ({"venue": "-a"}, "venue"),
        ({"venue": "a b"}, "venue"),
        ({"venue": "a\n"}, "venue"),
        ({"venue": "é"}, "venue"),
        ({"venue": "a" * 65}, "venue"),
        ({"venue": "a/../b"}, "venue"),
        ({"venue": "ok", "name": ""}, "name"),
        ({"venue": "ok", "name": "a\0b"}, "name"),
        ({"venue": "ok", "name": "n" * 201}, "name"),
        ({"venue": "ok", "nome": "x"}, "nome"),
    ],
)
def test_a_venue_that_cannot_be_made_is_refused_by_field(client: TestClient, body: dict[str, Any], field: str) -> None:
    answer = client.post("/v1/venues", json=body)
    assert answer.status_code == 422
    assert answer.headers["content-type"] == MEDIA_TYPE
    assert (answer.json()["field"], answer.json()["pointer"]) == (field, f"#/{field}")
    assert client.get("/v1/venues/ok").status_code == 404


@pytest.mark.parametrize("sent", [b"", b"{", b"[]", b"null", b'"x"', b"\xff", b'{"venue":"\\ud800"}', b'{"venue":NaN}'])
def test_a_body_that_is_no_venue_is_refused(client: TestClient, sent: bytes) -> None:
    answer = client.post("/v1/venues", content=sent, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422


def test_a_body_of_another_type_or_beyond_its_bound_is_refused(client: TestClient) -> None:
    sent = b'{"venue":"typed"}'
    for kind in ("text/plain", "application/msgpack", "application/x-www-form-urlencoded"):
        assert client.post("/v1/venues", content=sent, headers={"Content-Type": kind}).status_code == 415
    assert client.post("/v1/venues", content=b" " * 200_000 + sent).status_code == 413


def test_a_floor_is_new_first_and_changed_afterwards(client: TestClient, venue: str) -> None:
    body = {**FLOOR, "georeference": PLACE, "plan": PLAN}
    made = client.put(f"{venue}/floors/F1", json=body)
    assert made.status_code == 201
    assert made.json() == {
        **FLOOR,
        "floor": "F1",
        "georeference": PLACE,
        "has_plan": True,
        "has_image": False,
        "warnings": [],
    }
    changed = client.put(f"{venue}/floors/F1", json={**body, "level": -2})
    assert (changed.status_code, changed.json()["level"]) == (200, -2)
    read = client.get(f"{venue}/floors/F1").json()
    assert (read["plan"], read["georeference"], read["width"]) == (PLAN, PLACE, 96.5)
    assert client.get(f"{venue}/floors/F1/plan").json() == PLAN


def test_what_a_changed_floor_leaves_out_is_gone_but_for_the_image(client: TestClient, venue: str) -> None:
    client.put(f"{venue}/floors/F1", json={**FLOOR, "georeference": PLACE, "plan": PLAN})
    client.put(f"{venue}/floors/F1/image", content=png(), headers={"Content-Type": "image/png"})
    client.put(f"{venue}/floors/F1", json={key: value for key, value in FLOOR.items() if key != "name"})
    read = client.get(f"{venue}/floors/F1").json()
    assert (read["name"], read["georeference"], read["plan"]) == ("F1", None, None)
    assert client.get(f"{venue}/floors/F1/image").content == png()
    assert client.get(f"{venue}/floors/F1/plan").status_code == 404


def test_floors_are_listed_from_the_lowest_up(client: TestClient, venue: str) -> None:
    for floor, level in (("F2", 1), ("B1", -1), ("F1", 0)):
        client.put(f"{venue}/floors/{floor}", json={**FLOOR, "level": level})
    assert [floor["floor"] for floor in client.get(venue).json()["floors"]] == ["B1", "F1", "F2"]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"width": None}, "width"),
        ({"width": 0}, "width"),
        ({"height": -5}, "height"),
        ({"height": 1e308}, "height"),
        ({"height": "100"}, "height"),
        ({"level": None}, "level"),
        ({"level": 0.5}, "level"),
        ({"level": 10**30}, "level"),
        ({"name": 5}, "name"),
        ({"storey": 1}, "storey"),
        ({"georeference": {"latitude": 1}}, "georeference.longitude"),
        ({"georeference": {**PLACE, "latitude": 90.0}}, "georeference.latitude"),
        ({"georeference": {**PLACE, "longitude": "120"}}, "georeference.longitude"),
        ({"georeference": {**PLACE, "rotation": 90}}, "georeference.rotation"),
        ({"georeference": {**PLACE, "altitude": 4}}, "georeference.altitude"),
        ({"plan": 5}, "plan"),
        ({"plan": {"type": "Topology"}}, "plan.type"),
        ({"plan": {"type": "Point", "coordinates": [1, "2"]}}, "plan.coordinates[1]"),
    ],
)
def test_a_floor_that_cannot_be_is_refused_by_field_and_changes_nothing(
    client: TestClient, venue: str, change: dict[str, Any], field: str
) -> None:
    client.put(f"{venue}/floors/F1", json={**FLOOR, "plan": PLAN})
    before = everything(client, venue)
    for floor in ("F1", "F2"):
        answer = client.put(f"{venue}/floors/{floor}", json={**FLOOR, **change})
        assert answer.status_code == 422
        assert answer.json()["field"] == field
        assert answer.json()["pointer"] == "#/" + field.replace(".", "/").replace("[", "/").replace("]", "")
    assert everything(client, venue) == before


def test_a_floor_without_size_or_with_a_bad_identifier_is_refused(client: TestClient, venue: str) -> None:
    assert client.put(f"{venue}/floors/F1", json={"level": 0, "width": 5}).json()["field"] == "height"
    for floor in ("-F1", "F 1", "é", "f" * 65):
        answer = client.put(f"{venue}/floors/{floor}", json=FLOOR)
        assert (answer.status_code, answer.json()["field"]) == (422, "floor")
    assert everything(client, venue) == [[]]


def test_a_plan_that_is_nested_beyond_measure_is_refused(client: TestClient, venue: str) -> None:
    for depth in (300, 5000):
        nested = '{"x":' * depth + "1" + "}" * depth
        plan = json.dumps({**PLAN, "extra": "here"}).replace('"here"', nested)
        sent = json.dumps({**FLOOR, "plan": "here"}).replace('"here"', plan)
        assert client.put(f"{venue}/floors/F1", content=sent.encode()).status_code == 422


def test_what_is_wrong_with_a_plan_of_any_size_is_named_with_its_path(client: TestClient, venue: str) -> None:
    for size in (1, 2500):
        features = [{"type": "Feature", "properties": None, "geometry": None, "name": "a" * 50}] * size
        bad = {"type": "FeatureCollection", "features": [*features, {"type": "Feature", "geometry": 7}]}
        refused = client.put(f"{venue}/floors/F1", json={**FLOOR, "plan": bad})
        assert (refused.status_code, refused.json()["pointer"]) == (422, f"#/plan/features/{size}/geometry")
        assert client.put(f"{venue}/floors/F1", json={**FLOOR, "plan": {**bad, "features": features}}).is_success


def test_a_plan_that_lies_elsewhere_or_nowhere_is_accepted_with_a_warning(client: TestClient, venue: str) -> None:
    nowhere = client.put(f"{venue}/floors/F1", json={**FLOOR, "plan": PLAN})
    assert nowhere.status_code == 201 and "georeference" in nowhere.json()["warnings"][0]
    far = client.put(
        f"{venue}/floors/F1", json={**FLOOR, "plan": PLAN, "georeference": {"latitude": 48.1, "longitude": 11.5}}
    )
    assert far.status_code == 200 and "far away" in far.json()["warnings"][0]


def test_the_plans_of_the_open_data_are_taken_in_with_their_oddities(client: TestClient, venue: str) -> None:
    for floor in ("F1", "F2"):
        size = json.loads(open_data("mall", floor, "floor_info.json").read_text())["map_info"]
        plan = json.loads(open_data("mall", floor, "geojson_map.json").read_text())
        body = {
            **FLOOR,
            **size,
            "georeference": {"latitude": 30.29, "longitude": 120.07, "rotation": 0.0},
            "plan": plan,
        }
        packed = gzip.compress(json.dumps(body).encode())
        headers = {"Content-Type": "application/json", "Content-Encoding": "gzip"}
        made = client.put(f"{venue}/floors/{floor}", content=packed, headers=headers)
        assert made.status_code == 201, made.text
        assert any("turned round" in warning for warning in made.json()["warnings"])
        kept = client.get(f"{venue}/floors/{floor}").json()["plan"]["features"]
        assert [one["properties"] for one in kept] == [one["properties"] for one in plan["features"]]
        image = open_data("mall", floor, "floor_image.png").read_bytes()
        assert client.put(f"{venue}/floors/{floor}/image", content=image).status_code == 204
        assert client.get(f"{venue}/floors/{floor}/image").content == image


def test_an_image_is_replaced_and_an_unusable_one_changes_nothing(client: TestClient, venue: str) -> None:
    client.put(f"{venue}/floors/F1", json=FLOOR)
    path = f"{venue}/floors/F1/image"
    assert client.get(path).status_code == 404
    for width in (3, 6):
        assert client.put(path, content=png(width), headers={"Content-Type": "image/png"}).status_code == 204
    for sent, kind, status in (
        (png()[:-9], "image/png", 422),
        (b"GIF89a", "image/png", 422),
        (b"", "image/png", 422),
        (png(), "image/jpeg", 415),
        (b"\0" * 26_000_000, "image/png", 413),
    ):
        assert client.put(path, content=sent, headers={"Content-Type": kind}).status_code == status
    answer = client.get(path)
    assert (answer.content, answer.headers["content-type"]) == (png(6), "image/png")
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert client.get(f"{venue}/floors/F1").json()["has_image"] is True


@pytest.mark.parametrize("venue_id", ["none", "%00", "é", "a" * 300, "a%20b", "..%2fb"])
def test_an_unknown_venue_is_not_found(client: TestClient, venue_id: str) -> None:
    path = f"/v1/venues/{venue_id}"
    answers = [client.get(f"{path}{leaf}") for leaf in ("", "/floors/F1", "/floors/F1/plan", "/floors/F1/image")]
    answers += [client.get(f"{path}/phones"), client.put(f"{path}/floors/F1", json=FLOOR)]
    answers += [client.put(f"{path}/floors/F1/image", content=png())]
    assert [answer.status_code for answer in answers] == [404] * 7
    assert {answer.headers["content-type"] for answer in answers} == {MEDIA_TYPE}


@pytest.mark.parametrize("floor", ["F9", "%00", "é", "f" * 300])
def test_an_unknown_floor_is_not_found(client: TestClient, venue: str, floor: str) -> None:
    path = f"{venue}/floors/{floor}"
    answers = [client.get(f"{path}{leaf}") for leaf in ("", "/plan", "/image")]
    answers.append(client.put(f"{path}/image", content=png()))
    assert [answer.status_code for answer in answers] == [404] * 4


def test_a_session_sees_a_floor_as_soon_as_it_is_there(client: TestClient, venue: str) -> None:
    opening = {"venue": venue.rpartition("/")[2], "floor": "F1"}
    assert client.post("/v1/sessions", json=opening).status_code == 404
    client.put(f"{venue}/floors/F1", json=FLOOR)
    session = client.post("/v1/sessions", json={**opening, "method": "integrity_ukf"})
    assert session.status_code == 201, session.text
    batch = client.post(f"/v1/sessions/{session.json()['session']}/batches", json={"sequence": 0, "end": 10**12})
    assert batch.json()["integrity"]["flag"] == "initialising"
    (phone,) = client.get(f"{venue}/phones").json()["phones"]
    assert phone["fix"]["t"] == 10**12 and phone["age"] < 60


def test_what_is_stored_outlives_the_service(tmp_path: Path) -> None:
    with whole_service(tmp_path) as first:
        first.post("/v1/venues", json={"venue": "mall"})
        first.put("/v1/venues/mall/floors/F1", json={**FLOOR, "plan": PLAN})
        before = everything(first, "/v1/venues/mall")
    with whole_service(tmp_path) as second:
        assert everything(second, "/v1/venues/mall") == before
