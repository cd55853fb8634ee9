from __future__ import annotations

import errno
from typing import Any

import numpy as np
import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient

from app.api.geolocate import BODY_LIMIT_BYTES, geolocate_router, parse_scan
from app.api.problems import install_problems
from app.errors import DependencyDown, Forbidden, NotLocal, Unauthenticated
from app.floorplan.georeference import Georeference
from app.fusion.interface import Floor, Site
from app.observations import Position, WifiScan
from app.services.geolocation import Geolocation
from app.services.site_cache import SiteCache, SiteRevision
from app.wifi.locate import ScanPosition

FIRST = [0x0200000000A0 + i for i in range(6)]
SECOND = [0x0200000000A4 + i for i in range(6)]
ELSEWHERE = [0x0200000000F0 + i for i in range(6)]


class Map:
    """What a radio map is here: the access points of a floor."""

    def __init__(self, floor: str, bssid: list[int]) -> None:
        self.floor, self.bssid = floor, np.array(bssid)


def site(longitude_deg: float, bssid: list[int], georeferenced: bool = True) -> Site:
    georeference = Georeference(30.0, longitude_deg, 0.0) if georeferenced else None
    return Site({"F1": Floor("F1", 0, 50.0, 50.0, georeference)}, Map("F1", bssid))  # type: ignore[arg-type]


SITES = {
    "first": site(10.0, FIRST),
    "second": site(20.0, SECOND),
    "unplaced": site(0.0, ELSEWHERE, georeferenced=False),
    "empty": Site(),
}


class Venues:
    """The rows of those venues, as far as they are asked."""

    async def revisions(self) -> list[tuple[str, int]]:
        return [(venue, 1) for venue in SITES]


def located(radio_map: Any, scan: WifiScan) -> ScanPosition:
    return ScanPosition(Position(0.0, float(scan.bssid.size), radio_map.floor), 3.5)


@pytest.fixture
def client(monkeypatch: pytest.MonkeyPatch) -> TestClient:
    async def load(venue: str) -> SiteRevision:
        return SiteRevision(1, SITES[venue])

    monkeypatch.setattr("app.services.geolocation.locate_scan", located)
    service = Geolocation(Venues(), SiteCache(load))  # type: ignore[arg-type]
    app = FastAPI()
    app.include_router(geolocate_router(lambda: service, lambda: None))
    return TestClient(app, raise_server_exceptions=False)


def heard(bssids: list[int]) -> dict[str, Any]:
    points = [{"macAddress": f"{bssid:012x}", "signalStrength": -50, "age": 100, "channel": 11} for bssid in bssids]
    return {"considerIp": False, "wifiAccessPoints": points, "cellTowers": [{"cellId": 1}]}


@pytest.mark.parametrize(("bssids", "longitude"), [(FIRST, 10.0), (SECOND, 20.0), (FIRST[-3:] + SECOND[3:], 20.0)])
def test_the_venue_that_knows_most_of_the_scan_answers(client: TestClient, bssids: list[int], longitude: float) -> None:
    answer = client.post("/v1/geolocate", json=heard(bssids))
    assert answer.status_code == 200
    assert answer.json()["accuracy"] == 3.5
    assert answer.json()["location"]["lng"] == pytest.approx(longitude)
    assert answer.json()["location"]["lat"] == pytest.approx(30 + len(set(bssids)) / 111319.49)


@pytest.mark.parametrize("bssids", [[], FIRST[:1], FIRST[:1] * 3, [1, 2, 3], ELSEWHERE, [FIRST[0], ELSEWHERE[0]]])
def test_a_scan_that_no_georeferenced_venue_knows_is_not_found(client: TestClient, bssids: list[int]) -> None:
    answer = client.post("/v1/geolocate", json=heard(bssids))
    assert answer.status_code == 404
    error = answer.json()["error"]
    assert error["code"] == 404 and error["errors"][0]["reason"] == "notFound"
    assert error["errors"][0]["domain"] == "geolocation"


def test_an_empty_body_is_not_found(client: TestClient) -> None:
    assert client.post("/v1/geolocate").status_code == client.post("/v1/geolocate", json={}).status_code == 404


@pytest.mark.parametrize(
    "sent", [b"{", b"[]", b"null", b'{"wifiAccessPoints":1}', b'{"wifiAccessPoints":[{"signalStrength":"a"}]}', b"\xff"]
)
def test_a_body_that_cannot_be_read_is_a_parse_error(client: TestClient, sent: bytes) -> None:
    answer = client.post("/v1/geolocate", content=sent)
    assert answer.status_code == 400
    assert answer.json()["error"]["errors"][0]["reason"] == "parseError"


def test_a_body_beyond_its_bound_is_too_large_in_the_same_form(client: TestClient) -> None:
    for answer in (
        client.post("/v1/geolocate", content=b" " * (BODY_LIMIT_BYTES + 1)),
        client.post("/v1/geolocate", json=heard(list(range(1, 3000)))),
    ):
        error = answer.json()["error"]
        assert (answer.status_code, error["code"], error["errors"][0]["reason"]) == (413, 413, "uploadTooLarge")


@pytest.mark.parametrize(
    ("raised", "status", "reason", "header"),
    [
        (Unauthenticated("no key"), 401, "keyInvalid", "WWW-Authenticate"),
        (Forbidden("no scope"), 403, "accessNotConfigured", "WWW-Authenticate"),
        (NotLocal("elsewhere"), 403, "accessNotConfigured", None),
        (DependencyDown("away"), 503, "backendError", "Retry-After"),
        (OSError(errno.ENOSPC, "full"), 503, "backendError", "Retry-After"),
    ],
)
def test_what_keeps_requests_out_is_told_in_the_same_form(
    raised: Exception, status: int, reason: str, header: str | None
) -> None:
    def fail() -> None:
        raise raised

    app = FastAPI()
    install_problems(app)
    app.include_router(geolocate_router(lambda: None, fail))
    answer = TestClient(app).post("/v1/geolocate", json={})
    error = answer.json()["error"]
    assert (answer.status_code, answer.headers["content-type"]) == (status, "application/json")
    assert error == {"code": status, "message": error["message"], "errors": error["errors"]}
    assert [one["reason"] for one in error["errors"]] == [reason] and error["message"]
    assert header is None or header in answer.headers


def test_a_defect_is_a_defect_here_too() -> None:
    def fail() -> None:
        raise ZeroDivisionError

    app = FastAPI()
    install_problems(app)
    app.include_router(geolocate_router(lambda: None, fail))
    answer = TestClient(app, raise_server_exceptions=False).post("/v1/geolocate", json={})
    assert (answer.status_code, answer.headers["content-type"]) == (500, "application/problem+json")


def test_ages_count_and_unusable_access_points_are_left_out() -> None:
    scan = parse_scan(
        b'{"wifiAccessPoints":[{"macAddress":"01-02-03-04-05-06","signalStrength":-60,"age":2500},'
        b'{"macAddress":"junk","signalStrength":-60},{"macAddress":"010203040507"},{"signalStrength":-60},'
        b'{"macAddress":"010203040508","signalStrength":99}]}'
    )
    assert scan.bssid.tolist() == [0x010203040506]
    assert scan.time_s - scan.seen_s[0] == pytest.approx(2.5, abs=1e-3)
