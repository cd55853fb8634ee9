from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from app.api import openapi
from app.api.openapi import main, rendered
from app.main import create_app
from app.settings import Settings
from tests.api.whole_service import whole_service

COMMITTED = Path(__file__).parents[2] / "openapi" / "openapi.json"
CONTRACT = {
    "/v1/sessions": {"post"},
    "/v1/sessions/{session}": {"delete"},
    "/v1/sessions/{session}/batches": {"post"},
    "/v1/sessions/{session}/fix": {"get"},
    "/v1/sessions/{session}/track": {"get"},
    "/v1/sessions/{session}/events": {"get"},
    "/v1/sessions/{session}/tickets": {"post"},
    "/v1/geolocate": {"post"},
    "/v1/venues": {"get", "post"},
    "/v1/venues/{venue}": {"get"},
    "/v1/venues/{venue}/floors/{floor}": {"get", "put"},
    "/v1/venues/{venue}/floors/{floor}/image": {"get", "put"},
    "/v1/venues/{venue}/phones": {"get"},
    "/v1/venues/{venue}/surveys": {"post"},
    "/v1/venues/{venue}/radio-maps": {"get", "post"},
    "/v1/venues/{venue}/radio-map": {"put"},
    "/v1/venues/{venue}/radio-maps/{version}/watch-list": {"get", "post"},
    "/v1/venues/{venue}/radio-maps/{version}/watch-list/{bssid}": {"delete"},
    "/v1/venues/{venue}/radio-maps/{version}/quality": {"get"},
    "/v1/venues/{venue}/webhooks": {"get", "post"},
    "/v1/venues/{venue}/webhooks/{webhook}": {"delete"},
    "/v2/geosubmit": {"post"},
    "/healthz": {"get"},
    "/readyz": {"get"},
    "/metrics": {"get"},
}


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return create_app(Settings()).openapi()


def test_the_committed_document_is_that_of_the_service() -> None:
    assert main(["--check", str(COMMITTED)]) == 0


def test_every_path_of_the_contract_is_described(document: dict[str, Any]) -> None:
    for path, methods in CONTRACT.items():
        assert methods <= set(document["paths"][path]), path


def test_every_operation_says_what_it_does_and_how_it_fails(document: dict[str, Any]) -> None:
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            assert operation["summary"], (method, path)
            compatible = path in ("/v1/geolocate", "/v2/geosubmit")
            failure = "application/json" if compatible else "application/problem+json"
            assert list(operation["responses"]["default"]["content"]) == [failure]
            assert "422" not in operation["responses"]


def test_every_reference_leads_somewhere_and_every_operation_has_a_name_of_its_own(document: dict[str, Any]) -> None:
    for name in re.findall(r'"#/components/schemas/([^"]+)"', json.dumps(document)):
        assert name in document["components"]["schemas"], name
    names = [one["operationId"] for operations in document["paths"].values() for one in operations.values()]
    assert len(set(names)) == len(names)


def test_what_needs_a_key_says_so(document: dict[str, Any]) -> None:
    without = ("/healthz", "/readyz", "/metrics", "/v1/sessions/{session}/events")  # the last takes a ticket instead
    for path, operations in document["paths"].items():
        for operation in operations.values():
            assert ("security" in operation) == (path not in without), path
    assert document["components"]["securitySchemes"]["key"]["scheme"] == "bearer"


def test_the_same_service_gives_the_same_text() -> None:
    assert rendered(create_app(Settings())) == rendered(create_app(Settings(database="sqlite:///other.db", port=1)))


def test_a_document_that_differs_is_found_and_writing_mends_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "folder" / "openapi.json"
    assert main(["--check", str(path)]) == 1
    assert main([str(path)]) == 0
    assert main(["--check", str(path)]) == 0
    path.write_text(path.read_text().replace("Surefix", "Other"))
    assert main(["--check", str(path)]) == 1
    assert "make openapi" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [[], ["--check"], ["one", "two"]])
def test_the_command_explains_itself(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    assert openapi.__doc__ is not None and openapi.__doc__ in capsys.readouterr().err


def test_the_examples_of_bodies_make_a_venue_survey_it_and_locate_a_phone_there(
    document: dict[str, Any], tmp_path: Path
) -> None:
    def example(method: str, path: str) -> Any:
        return document["paths"][path][method]["requestBody"]["content"]["application/json"]["example"]

    bodies = {
        (method, path)
        for path, operations in document["paths"].items()
        for method, operation in operations.items()
        if "application/json" in operation.get("requestBody", {}).get("content", {})
    }
    museum, floor = {"venue": "museum", "floor": "F1"}, "/v1/venues/{venue}/floors/{floor}"
    maps, in_session = "/v1/venues/{venue}/radio-maps", "/v1/sessions/{session}/batches"
    told = dict[str, Any]()
    with whole_service(tmp_path) as client:
        for method, path in (
            ("post", "/v1/venues"),
            ("put", floor),
            ("post", "/v1/venues/{venue}/surveys"),
            ("post", maps),
            ("put", "/v1/venues/{venue}/radio-map"),
            ("post", "/v1/sessions"),
            ("post", in_session),
            ("post", "/v1/geolocate"),
            ("post", "/v2/geosubmit"),
            ("post", f"{maps}/{{version}}/watch-list"),
            ("post", "/v1/venues/{venue}/webhooks"),
        ):
            address = path.format(**museum, version=1, session=told.get("/v1/sessions", {}).get("session"))
            answer = client.request(method, address, json=example(method, path))
            assert answer.is_success, answer.text
            told[path] = answer.json()
            bodies.discard((method, path))
    assert bodies == set()
    assert abs(told[in_session]["position"]["x"] - 15.0) < 5.0
    assert told["/v1/geolocate"]["accuracy"] > 0
