from __future__ import annotations

import errno
import inspect
import json
import logging
import re

import pytest
from fastapi import Depends, FastAPI, Query
from fastapi.testclient import TestClient
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from app import errors
from app.api.problems import MEDIA_TYPE, PROBLEMS, TYPE, install_problems, json_pointer
from app.errors import (
    Conflict,
    DependencyDown,
    Expired,
    Forbidden,
    InvalidInput,
    NotFound,
    NotLocal,
    SurefixError,
    TooLarge,
    Unauthenticated,
    UnsupportedMedia,
)

LEAVES = [
    kind
    for _, kind in inspect.getmembers(errors, inspect.isclass)
    if issubclass(kind, SurefixError) and not kind.__subclasses__()
]


class Unmapped(SurefixError):
    """An error that the table does not know."""


class Body(BaseModel):
    count: int


def client_of(error: Exception) -> TestClient:
    """A service whose every request ends in that error."""
    app = FastAPI()
    install_problems(app)

    def fail() -> None:
        raise error

    @app.get("/fail", dependencies=[Depends(fail)])
    @app.put("/fail/{floor}", dependencies=[Depends(fail)])
    def nothing(floor: str = "") -> None:
        raise AssertionError("not reached")

    @app.post("/count")
    def count(body: Body, limit: int = Query(1, ge=1)) -> int:
        return body.count + limit

    return TestClient(app, raise_server_exceptions=False)


@pytest.mark.parametrize("kind", LEAVES)
def test_every_leaf_of_the_error_tree_is_in_the_table(kind: type[SurefixError]) -> None:
    assert kind in PROBLEMS


def test_types_and_names_are_unique_and_statuses_are_errors() -> None:
    names = [
        problem.name for kind, problem in PROBLEMS.items() if kind is not NotLocal
    ]  # forbidden, for another reason
    assert len(set(names)) == len(names)
    assert len({problem.title for problem in PROBLEMS.values()}) == len(PROBLEMS)
    assert all(400 <= problem.status < 600 for problem in PROBLEMS.values())


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (InvalidInput("wrong"), 422),
        (TooLarge("much"), 413),
        (UnsupportedMedia("strange"), 415),
        (NotFound("none"), 404),
        (Expired("over"), 410),
        (Conflict("twice"), 409),
        (Unauthenticated("who"), 401),
        (Forbidden("no"), 403),
        (NotLocal("elsewhere"), 403),
        (DependencyDown("away"), 503),
    ],
)
def test_an_error_is_answered_as_a_problem_document(error: SurefixError, status: int) -> None:
    answer = client_of(error).get("/fail")
    assert answer.status_code == status
    assert answer.headers["content-type"] == MEDIA_TYPE
    document = answer.json()
    assert document["status"] == status
    assert document["detail"] == str(error)
    assert document["type"] == TYPE + PROBLEMS[type(error)].name
    assert document["title"]


def test_the_field_of_a_body_comes_with_a_pointer_and_that_of_a_path_or_query_without() -> None:
    client = client_of(InvalidInput("wrong", "plan.features[3].geometry"))
    document = client.put("/fail/F1").json()
    assert document["field"] == "plan.features[3].geometry"
    assert document["pointer"] == "#/plan/features/3/geometry"
    assert "pointer" not in client.get("/fail").json()
    for_path = client_of(InvalidInput("wrong", "floor"))
    document = for_path.put("/fail/F1").json()
    assert document["field"] == "floor" and "pointer" not in document


def test_a_store_that_is_down_says_when_to_come_back_and_a_missing_key_how_to_send_one() -> None:
    assert client_of(DependencyDown("away", retry_after_s=7)).get("/fail").headers["retry-after"] == "7"
    assert client_of(Unauthenticated("who")).get("/fail").headers["www-authenticate"].startswith("Bearer")
    assert "insufficient_scope" in client_of(Forbidden("no")).get("/fail").headers["www-authenticate"]


def test_a_request_of_another_site_is_not_told_that_its_key_lacks_a_scope() -> None:
    answer = client_of(NotLocal("elsewhere")).get("/fail")
    assert answer.json()["type"] == TYPE + "forbidden"
    assert answer.json()["title"] == "Without API keys only this machine is answered"
    assert "www-authenticate" not in answer.headers


@pytest.mark.parametrize("error", [ZeroDivisionError("secret"), Unmapped("secret")])
def test_a_defect_is_logged_and_shows_nothing_of_the_inside(error: Exception, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        answer = client_of(error).get("/fail")
    assert answer.status_code == 500
    assert answer.headers["content-type"] == MEDIA_TYPE
    assert answer.json()["type"] == TYPE + "defect"
    assert "secret" not in answer.text and type(error).__name__ not in answer.text
    assert f"GET /fail failed: {type(error).__name__}" in caplog.text


@pytest.mark.parametrize(("number", "status"), [(errno.ENOSPC, 503), (errno.EDQUOT, 503), (errno.EACCES, 500)])
def test_a_full_disk_is_told_to_come_again_and_no_defect(number: int, status: int) -> None:
    answer = client_of(OSError(number, "of the disk")).get("/fail")
    assert answer.status_code == status
    assert ("Retry-After" in answer.headers) == (status == 503)


def test_the_log_does_not_name_what_a_path_was_filled_in_with(caplog: pytest.LogCaptureFixture) -> None:
    for error in (DependencyDown("away"), ZeroDivisionError()):
        with caplog.at_level(logging.WARNING):
            client_of(error).put("/fail/secret-of-a-phone")
    assert "PUT /fail/{floor}" in caplog.text and "secret-of-a-phone" not in caplog.text


def test_unknown_routes_and_methods_are_problems_too() -> None:
    client = client_of(NotFound(""))
    unknown, method = client.get("/nothing"), client.delete("/fail")
    assert (unknown.status_code, unknown.json()["type"]) == (404, TYPE + "not-found")
    assert (method.status_code, method.json()["type"]) == (405, TYPE + "method-not-allowed")
    assert "GET" in method.headers["allow"]
    assert unknown.headers["content-type"] == method.headers["content-type"] == MEDIA_TYPE


@pytest.mark.parametrize(
    ("sent", "query", "field", "pointer"),
    [
        (b'{"count":"x"}', "", "count", "#/count"),
        (b"{}", "", "count", "#/count"),
        (b'{"count":1}', "?limit=0", "limit", None),
        (b"{", "", None, None),
    ],
)
def test_what_the_framework_refuses_names_the_field(
    sent: bytes, query: str, field: str | None, pointer: str | None
) -> None:
    answer = client_of(NotFound("")).post(f"/count{query}", content=sent, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422
    document = answer.json()
    assert document["type"] == TYPE + "invalid-input"
    assert (document.get("field"), document.get("pointer")) == (field, pointer)


@given(st.lists(st.text(st.characters(exclude_characters=".[]"), min_size=1) | st.integers(0, 10**6), min_size=1))
def test_a_pointer_has_a_part_for_each_part_of_the_path(parts: list[str | int]) -> None:
    path = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in parts).removeprefix(".")
    pointed = json_pointer(path).removeprefix("#/").split("/")
    assert [re.sub("~1", "/", part).replace("~0", "~") for part in pointed] == [str(part) for part in parts]


@given(st.text(), st.text())
def test_any_message_and_field_make_a_document(message: str, field: str) -> None:
    answer = client_of(InvalidInput(message + "\ud800", field + "\udfff")).put("/fail/F1")
    assert answer.status_code == 422
    assert json.loads(answer.content)["detail"] == message + "\ud800"
