"""A name that nothing can have is not found, also where the database is one that fails over a NUL."""

from __future__ import annotations

import io
from collections.abc import Iterator

import pytest
from fastapi.testclient import TestClient
from PIL import Image

from app.main import create_app
from app.settings import Settings
from app.storage.migration import migrate
from tests.api.survey_service import problem
from tests.api.whole_service import LOOPBACK
from tests.postgresql_process import PostgresqlProcess

VENUE = "/v1/venues/a%00b"
WATCHED = {"bssid": "a8:0c:ca:03:9d:d7"}


@pytest.fixture(scope="module")
def client() -> Iterator[TestClient]:
    server = PostgresqlProcess()
    server.start()
    try:
        database = server.new_database()
        migrate(database)
        with TestClient(create_app(Settings(database=database)), LOOPBACK, raise_server_exceptions=False) as made:
            made.post("/v1/venues", json={"venue": "mall"})
            yield made
    finally:
        server.remove()


@pytest.mark.parametrize(
    ("method", "path", "sent"),
    [
        ("GET", VENUE, None),
        ("GET", f"{VENUE}/phones", None),
        ("GET", f"{VENUE}/floors/F1", None),
        ("POST", f"{VENUE}/surveys", {"floor": "F1", "fingerprints": []}),
        ("GET", f"{VENUE}/radio-maps", None),
        ("PUT", f"{VENUE}/radio-map", {"version": 1}),
        ("GET", f"{VENUE}/radio-maps/1/quality", None),
        ("GET", f"{VENUE}/radio-maps/1/watch-list", None),
        ("POST", f"{VENUE}/radio-maps/1/watch-list", WATCHED),
        ("DELETE", f"{VENUE}/radio-maps/1/watch-list/{WATCHED['bssid']}", None),
        ("GET", f"{VENUE}/webhooks", None),
        ("GET", "/v1/venues/mall/floors/a%00b", None),
        ("DELETE", "/v1/venues/mall/webhooks/a%00b", None),
        ("DELETE", "/v1/venues/mall/radio-maps/1/watch-list/a%00b", None),
        ("GET", "/v1/sessions/a%00b/fix", None),
        ("GET", "/v1/tasks/a%00b", None),
    ],
)
def test_a_name_with_a_nul_is_not_found(
    client: TestClient, method: str, path: str, sent: dict[str, object] | None
) -> None:
    problem(client.request(method, path, json=sent), 404)


def test_an_image_of_a_floor_with_a_nul_is_not_taken(client: TestClient) -> None:
    picture = io.BytesIO()
    Image.new("RGB", (4, 4)).save(picture, "PNG")
    headers = {"Content-Type": "image/png"}
    problem(client.put("/v1/venues/mall/floors/a%00b/image", content=picture.getvalue(), headers=headers), 404)
