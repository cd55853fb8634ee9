from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.services.webhooks import MOST
from tests.api.whole_service import whole_service

HOOKS = "/v1/venues/mall/webhooks"


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with whole_service(tmp_path_factory.mktemp("webhooks")) as made:
        for venue in ("mall", "other"):
            assert made.post("/v1/venues", json={"venue": venue}).status_code == 201
        yield made


def test_a_webhook_is_registered_listed_and_removed_and_its_secret_shown_once(client: TestClient) -> None:
    made = client.post(HOOKS, json={"url": "https://alerts.example/hook?who=me"})
    assert made.status_code == 201
    assert made.json()["secret"].startswith("whsec_")
    listed = client.get(HOOKS).json()["webhooks"]
    assert [one["url"] for one in listed] == ["https://alerts.example/hook?who=me"]
    assert listed[0] == {
        "webhook": made.json()["webhook"],
        "url": made.json()["url"],
        "created": made.json()["created"],
        "delivered": None,
        "failure": None,
        "waiting": 0,
    }
    assert client.get("/v1/venues/other/webhooks").json() == {"webhooks": []}
    assert client.delete(f"/v1/venues/other/webhooks/{listed[0]['webhook']}").status_code == 404
    assert client.delete(f"{HOOKS}/{listed[0]['webhook']}").status_code == 204
    assert client.delete(f"{HOOKS}/{listed[0]['webhook']}").status_code == 404
    assert client.get(HOOKS).json() == {"webhooks": []}


def test_no_two_webhooks_have_the_same_secret(client: TestClient) -> None:
    made = [client.post("/v1/venues/other/webhooks", json={"url": "http://a/"}).json() for _ in range(3)]
    assert len({one["secret"] for one in made}) == len({one["webhook"] for one in made}) == 3


@pytest.mark.parametrize(
    "url",
    [
        "",
        "alerts.example",
        "ftp://alerts.example/",
        "file:///etc/passwd",
        "http://",
        "http://[::1",
        "http://a:99999/",
        "http://me:secret@alerts.example/",
        "http://a/#part",
        "http://a/ b",
        "http://a/\n",
        "http://ä.example/",
        "http://xn--a/",
        "http://a/" + "x" * 2000,
    ],
)
def test_what_cannot_be_posted_to_is_refused_and_named(client: TestClient, url: str) -> None:
    answer = client.post(HOOKS, json={"url": url})
    assert (answer.status_code, answer.json()["field"]) == (422, "url")


@pytest.mark.parametrize(
    "host",
    [
        "169.254.169.254",
        "169.254.0.1:8080",
        "169.254.169.254.",
        "2852039166",
        "0xa9.254.43518",
        "[fe80::1]",
        "[febf::1%25eth0]",
        "[::ffff:169.254.169.254]",
        "[fd00:ec2::254]",
        "100.100.100.200",
    ],
)
def test_a_link_local_or_metadata_address_is_refused_with_the_remedy(client: TestClient, host: str) -> None:
    answer = client.post(HOOKS, json={"url": f"http://{host}/hook"})
    assert (answer.status_code, answer.json()["pointer"]) == (422, "#/url")
    assert "name the receiver's own" in answer.json()["detail"]


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "localhost", "10.1.2.3", "192.168.0.1", "172.16.9.9", "[::1]", "[fd00::1]", "169.253.1.1"]
)
def test_addresses_of_the_own_network_are_allowed(client: TestClient, host: str) -> None:
    made = client.post("/v1/venues/other/webhooks", json={"url": f"http://{host}/hook"})
    assert made.status_code == 201
    client.delete(f"/v1/venues/other/webhooks/{made.json()['webhook']}")


@pytest.mark.parametrize("body", [{}, {"url": 1}, {"url": "http://a/", "secret": "mine"}])
def test_a_body_that_is_none_is_refused(client: TestClient, body: dict[str, object]) -> None:
    assert client.post(HOOKS, json=body).status_code == 422


def test_a_venue_that_does_not_exist_has_no_webhooks(client: TestClient) -> None:
    assert client.post("/v1/venues/none/webhooks", json={"url": "http://a/"}).status_code == 404
    assert client.get("/v1/venues/none/webhooks").status_code == 404
    assert client.delete("/v1/venues/none/webhooks/x").status_code == 404


def test_there_are_only_so_many_webhooks(tmp_path: Path) -> None:
    with whole_service(tmp_path) as service:
        service.post("/v1/venues", json={"venue": "mall"})
        statuses = [service.post(HOOKS, json={"url": f"http://a/{n}"}).status_code for n in range(MOST + 1)]
        assert statuses == [201] * MOST + [409]
