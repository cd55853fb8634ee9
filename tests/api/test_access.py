from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient

from app.api.problems import MEDIA_TYPE, PROBLEMS
from app.errors import NotLocal
from app.main import create_app
from app.services.access import Scope
from app.settings import Settings
from tests.api.whole_service import make_key, whole_service

COMPATIBLE = {"/v1/geolocate", "/v2/geosubmit"}
"""Errors of another form."""
OPEN_TO_ALL = {"/healthz", "/readyz", "/metrics"}
"""No key is needed; of /metrics on loopback only."""
NEEDED = {
    "/v1/sessions": {Scope.POSITION},
    "/v1/sessions/{session}/batches": {Scope.POSITION},
    "/v1/sessions/{session}/fix": {Scope.POSITION},
    "/v1/sessions/{session}/track": {Scope.POSITION},
    "/v1/sessions/{session}": {Scope.POSITION},
    "/v1/sessions/{session}/tickets": {Scope.POSITION},
    "/v1/sessions/{session}/events": {Scope.POSITION},
    "/v1/geolocate": {Scope.POSITION},
    "/v2/geosubmit": {Scope.SURVEY, Scope.ADMIN},
    "/v1/venues/{venue}/surveys": {Scope.SURVEY, Scope.ADMIN},
    "/v1/venues/{venue}/phones": {Scope.ADMIN},
    "/v1/venues/{venue}/webhooks": {Scope.ADMIN},
    "/v1/venues/{venue}/webhooks/{webhook}": {Scope.ADMIN},
    "/v1/venues/{venue}/radio-maps/{version}/watch-list": {Scope.ADMIN},
    "/v1/venues/{venue}/radio-maps/{version}/watch-list/{bssid}": {Scope.ADMIN},
    "/v1/venues/{venue}/radio-maps/{version}/quality": {Scope.SURVEY, Scope.ADMIN},
    "/v1/venues/{venue}/radio-maps/{version}/quality.html": {Scope.SURVEY, Scope.ADMIN},
    "/v1/venues/{venue}/radio-maps/{version}/quality.png": {Scope.SURVEY, Scope.ADMIN},
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("keys")


@pytest.fixture(scope="module")
def keys(folder: Path) -> dict[Scope, str]:
    return {scope: make_key(folder, scope) for scope in Scope}


@pytest.fixture(scope="module")
def client(folder: Path, keys: dict[Scope, str]) -> Iterator[TestClient]:
    assert keys
    with whole_service(folder) as made:
        yield made


def bearer(key: str) -> dict[str, str]:
    return {"Authorization": f"Bearer {key}"}


def every_operation() -> list[tuple[str, str]]:
    """Method and path of every operation that the API page lists."""
    paths: dict[str, dict[str, Any]] = create_app(Settings()).openapi()["paths"]
    return [(method.upper(), path) for path, operations in paths.items() for method in operations]


@pytest.mark.parametrize(("method", "path"), [one for one in every_operation() if one[1] not in OPEN_TO_ALL])
def test_once_a_key_exists_every_operation_needs_one(client: TestClient, method: str, path: str) -> None:
    address = re.sub(r"\{\w+\}", "x", path)
    for headers in ({}, bearer("wrong"), {"Authorization": "Basic eDp5"}, {"Authorization": "Bearer"}):
        answer = client.request(method, address, headers=headers, json={})
        assert answer.status_code == 401
        assert answer.headers["content-type"] == ("application/json" if path in COMPATIBLE else MEDIA_TYPE)
        assert answer.headers["www-authenticate"].startswith("Bearer")


@pytest.mark.parametrize(("method", "path"), [one for one in every_operation() if one[1] in NEEDED])
@pytest.mark.parametrize("scope", list(Scope))
def test_a_key_opens_what_its_scope_is_for(
    client: TestClient, keys: dict[Scope, str], method: str, path: str, scope: Scope
) -> None:
    answer = client.request(method, re.sub(r"\{\w+\}", "x", path), headers=bearer(keys[scope]), json={})
    assert (answer.status_code == 403) == (scope not in NEEDED[path])
    assert answer.status_code != 401


def test_reading_venues_takes_any_scope_and_changing_them_takes_admin(
    client: TestClient, keys: dict[Scope, str]
) -> None:
    for scope, key in keys.items():
        made = client.post("/v1/venues", json={"venue": f"of-{scope}"}, headers=bearer(key))
        assert made.status_code == (201 if scope is Scope.ADMIN else 403)
        put = client.put("/v1/venues/x/floors/F1", json={}, headers=bearer(key))
        assert put.status_code == (422 if scope is Scope.ADMIN else 403)
        assert client.get("/v1/venues", headers=bearer(key)).status_code == 200


@pytest.mark.parametrize(("path", "scope"), [("/v1/geolocate", Scope.POSITION), ("/v2/geosubmit", Scope.SURVEY)])
def test_compatible_endpoints_take_the_key_from_the_query_and_no_others_do(
    client: TestClient, keys: dict[Scope, str], path: str, scope: Scope
) -> None:
    assert client.post(path, params={"key": keys[scope]}, json={}).status_code not in (401, 403)
    assert client.post(path, params={"key": "wrong"}, json={}).status_code == 401
    other = Scope.SURVEY if scope is Scope.POSITION else Scope.POSITION
    assert client.post(path, params={"key": keys[other]}, json={}).status_code == 403
    assert client.post("/v1/sessions", params={"key": keys[Scope.POSITION]}, json={}).status_code == 401


def test_the_scheme_is_read_whatever_its_case(client: TestClient, keys: dict[Scope, str]) -> None:
    assert client.get("/v1/venues", headers={"Authorization": f"bEARER  {keys[Scope.ADMIN]}"}).status_code == 200


@pytest.mark.parametrize(
    "path", ["/", "/console/console.js", "/docs", "/docs/swagger-ui.css", "/openapi.json", *sorted(OPEN_TO_ALL)]
)
def test_the_page_its_files_and_the_health_of_the_service_need_no_key(client: TestClient, path: str) -> None:
    assert client.get(path).status_code == 200


def test_off_loopback_a_key_is_needed_from_the_start_and_for_the_metrics_too(tmp_path: Path) -> None:
    with whole_service(tmp_path, host="0.0.0.0") as service:
        assert service.get("/v1/venues").status_code == 401
        assert service.get("/metrics").status_code == 401
        assert service.get("/readyz").status_code == 200
        position, admin = make_key(tmp_path, Scope.POSITION), make_key(tmp_path, Scope.ADMIN)
        assert service.get("/metrics", headers=bearer(position)).status_code == 403
        assert service.get("/metrics", headers=bearer(admin)).status_code == 200


def test_on_loopback_without_any_key_everything_is_open(tmp_path: Path) -> None:
    with whole_service(tmp_path) as service:
        assert service.post("/v1/venues", json={"venue": "mall"}).status_code == 201
        assert service.post("/v1/sessions", json={"venue": "none"}).status_code in (404, 422)


@pytest.fixture(scope="module")
def keyless(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with whole_service(tmp_path_factory.mktemp("keyless")) as made:
        yield made


@pytest.mark.parametrize("host", ["127.0.0.1:8000", "localhost:1", "LOCALHOST", "[::1]:8000", "127.0.0.1"])
@pytest.mark.parametrize("origin", [None, "http://localhost:3000", "http://127.0.0.1:8000", "http://[::1]"])
def test_without_keys_programs_and_pages_of_this_machine_pass(
    keyless: TestClient, host: str, origin: str | None
) -> None:
    headers = {"Host": host} if origin is None else {"Host": host, "Origin": origin}
    assert keyless.post("/v1/venues", json={}, headers=headers).status_code == 422
    assert keyless.get("/v1/venues", headers=headers).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"Origin": "https://evil.example"},
        {"Origin": "null"},
        {"Origin": "http://127.0.0.1.evil.example"},
        {"Origin": "http://127.0.0.1@evil.example"},
        {"Host": "evil.example:8000"},
        {"Host": "localhost.evil.example"},
        {"Host": "192.0.2.1:8000", "Origin": "http://localhost"},
        {"Host": "[nonsense"},
    ],
)
def test_without_keys_a_page_of_elsewhere_cannot_use_the_browser_to_get_in(
    keyless: TestClient, headers: dict[str, str]
) -> None:
    for method, path in (("POST", "/v1/venues"), ("GET", "/v1/venues"), ("DELETE", f"/v1/sessions/{0:032x}")):
        answer = keyless.request(method, path, headers=headers)
        assert (answer.status_code, answer.headers["content-type"]) == (403, MEDIA_TYPE)
        assert answer.json()["title"] == PROBLEMS[NotLocal].title
    form = {"Content-Type": "text/plain", **headers}
    assert keyless.post("/v1/geolocate", content=b"{}", headers=form).status_code == 403


def test_with_a_key_any_name_may_be_called(client: TestClient, keys: dict[Scope, str]) -> None:
    headers = {"Host": "positions.example", "Origin": "https://app.example", **bearer(keys[Scope.ADMIN])}
    assert client.get("/v1/venues", headers=headers).status_code == 200
