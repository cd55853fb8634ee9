from __future__ import annotations

import asyncio
import base64
import hashlib
import math
import re
import struct
import time
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fastapi.testclient import TestClient
from httpx import Response

from app.services.map_use import PERIOD_MS
from app.services.worker_processes import WorkerProcesses
from app.storage.database import connect
from app.storage.map_use_rows import MapUseRows, UsedSquare, UseRow
from app.survey.admission import GROUPS
from app.wifi.bssid import format_bssid
from tests.api.whole_service import database_in, whole_service
from tests.services.test_quality_report import survey

MAP = "/v1/venues/mall/radio-maps/1"
PATIENCE_S = 120.0
WATCHED = format_bssid(2)
STRANGE = "<script>alert(1)</script>"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the service keeps its database."""
    return tmp_path_factory.mktemp("quality")


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[TestClient]:
    """The service, with a venue that was surveyed by several walks; its report is not made yet."""
    with whole_service(folder) as made:
        made.post("/v1/venues", json={"venue": "mall"})
        made.put("/v1/venues/mall/floors/F1", json={"level": 0, "width": 60.0, "height": 20.0})
        for walk in range(3):
            here = [one for one in survey(("F1",)) if one.walk == f"F1 {walk}"]
            fingerprints = [
                {
                    "x": one.x_m,
                    "y": one.y_m,
                    "t": 1_700_000_000_000 + 1000 * at,
                    "readings": [
                        {"bssid": format_bssid(bssid), "rssi": rssi_dbm}
                        for bssid, rssi_dbm in zip(one.bssid.tolist(), one.rssi_dbm.tolist(), strict=True)
                    ],
                }
                for at, one in enumerate(here)
            ]
            sent = {"floor": "F1", "fingerprints": fingerprints}
            answer = made.post("/v1/venues/mall/surveys", params={"publish": walk == 2}, json=sent)
            assert answer.status_code == 201, answer.text
        yield made


@pytest.fixture(scope="module")
def made(client: TestClient) -> dict[str, Any]:
    """The report, once it is made; what was answered on the way is told as `started`, `waiting` and `fetched`."""
    waiting, started = client.get(f"{MAP}/quality.html"), client.get(f"{MAP}/quality")
    fetched = client.get(f"{MAP}/quality.html", headers={"Authorization": "Bearer any"})
    return {**finished(client).json(), "waiting": waiting, "started": started, "fetched": fetched}


def surveyed(client: TestClient, venue: str) -> str:
    """A new venue of one floor, with a map of one fingerprint."""
    client.post("/v1/venues", json={"venue": venue})
    client.put(f"/v1/venues/{venue}/floors/F1", json={"level": 0, "width": 60.0, "height": 20.0})
    readings = [{"bssid": format_bssid(number), "rssi": -50} for number in range(1, 5)]
    sent = {"floor": "F1", "fingerprints": [{"x": 5.0, "y": 5.0, "t": 1_700_000_000_000, "readings": readings}]}
    answer = client.post(f"/v1/venues/{venue}/surveys", params={"publish": True}, json=sent)
    assert answer.status_code == 201, answer.text
    return venue


def finished(client: TestClient, at: str = MAP) -> Response:
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline:
        answer: Response = client.get(f"{at}/quality")
        if answer.status_code == 200:
            return answer
        assert answer.status_code == 202, answer.text
    pytest.fail("the report was never made")


def test_until_the_report_is_made_its_one_task_is_told(client: TestClient, made: dict[str, Any]) -> None:
    started, waiting = made["started"], made["waiting"]
    assert (started.status_code, waiting.status_code) == (202, 202)
    assert started.headers["location"] == waiting.headers["location"] == started.json()["task"]
    assert int(started.headers["retry-after"]) > 0
    assert '<meta http-equiv="refresh"' in waiting.text and waiting.headers["content-type"].startswith("text/html")
    task = client.get(started.json()["task"]).json()
    assert (task["status"], task["problem"]) == ("done", None)


def test_who_fetches_the_page_with_a_key_gets_none_that_would_load_itself_again_without_it(
    made: dict[str, Any],
) -> None:
    assert made["fetched"].status_code == 202 and "refresh" not in made["fetched"].text


def test_the_report_says_how_good_the_map_is(made: dict[str, Any]) -> None:
    assert (made["version"], made["fingerprints"]) == (1, 63)
    assert 3 < made["walks"] <= 3 * GROUPS  # points are left out in groups of each survey
    assert made["error"]["mean"] > 0.0
    assert made["floors"][0]["cells"] and made["floors"][0]["coverage"]["gaps"]
    drift = made["drift"]
    assert (drift["score"], drift["squares"], drift["resurvey"]) == (None, 0, [])
    assert (drift["watched_share"], drift["access_points"]) == (0.0, [])
    assert not {"strongest", "likeness", "floor_names", "canvases"} & made.keys()


def test_the_picture_is_a_png(client: TestClient, made: dict[str, Any]) -> None:
    picture = client.get(f"{MAP}/quality.png")
    assert picture.headers["content-type"] == "image/png" and picture.content.startswith(b"\x89PNG")


def test_the_page_is_one_file_that_shows_the_picture_and_loads_nothing(
    client: TestClient, made: dict[str, Any]
) -> None:
    page = client.get(f"{MAP}/quality.html")
    assert page.status_code == 200
    (picture,) = re.findall(r'<img src="data:image/png;base64,([^"]+)"', page.text)
    assert base64.b64decode(picture) == client.get(f"{MAP}/quality.png").content
    assert not re.search(r"<script|<link|https?://|\sstyle=|\son\w+=", page.text)
    policy = page.headers["content-security-policy"]
    (style,) = re.findall(r"<style>(.*?)</style>", page.text, re.DOTALL)
    assert "default-src 'none'" in policy and "unsafe" not in policy
    assert base64.b64encode(hashlib.sha256(style.encode()).digest()).decode() in policy


def test_what_use_has_shown_since_is_in_the_report_and_text_stays_text(
    client: TestClient, made: dict[str, Any]
) -> None:
    client.post(f"{MAP}/watch-list", json={"bssid": WATCHED, "reason": STRANGE})
    client.post(f"{MAP}/watch-list", json={"bssid": "ff:ff:ff:ff:ff:fe"})  # not of this map
    drift = finished(client).json()["drift"]
    assert drift["watched_share"] == pytest.approx(1.0 / made["access_points"]["known"])
    (again,) = drift["access_points"]
    assert (again["bssid"], again["reason"], again["floor"]) == (WATCHED, STRANGE, "F1")
    assert abs(again["x"] - 16.0) <= 4.0  # where it stands
    page = client.get(f"{MAP}/quality.html").text
    assert WATCHED in page and STRANGE not in page and "&lt;script&gt;" in page
    client.delete(f"{MAP}/watch-list/{WATCHED}")
    assert finished(client).json()["drift"]["access_points"] == []


def test_squares_that_use_has_found_changed_are_listed_and_drawn(
    client: TestClient, made: dict[str, Any], folder: Path
) -> None:
    before = client.get(f"{MAP}/quality.png").content
    bits, mean = (1 << 20) - 1, math.log(0.9)
    use = UseRow(80, 8, 20, 20 * mean, 20 * mean**2, bits, time.time_ns() // 1_000_000)
    period = time.time_ns() // 1_000_000 // PERIOD_MS

    async def add() -> None:
        engine = connect(database_in(folder))
        await MapUseRows(engine).add({("mall", 1): {UsedSquare("F1", 2, 0, period): use}})
        await engine.dispose()

    asyncio.run(add())
    drift = finished(client).json()["drift"]
    (again,) = drift["resurvey"]
    assert (again["floor"], again["x"], again["y"], again["size"]) == ("F1", 25.0, 5.0, 10.0)
    assert (again["scans"], again["unfit"], again["visits"]) == (80, 8, 20) and again["surveyed"] > 0
    assert again["reason"] == "changed since it was surveyed"
    assert (drift["squares"], drift["score"]) == (1, again["ratio"]) and drift["score"] > 3.0
    after = client.get(f"{MAP}/quality.png").content
    page = client.get(f"{MAP}/quality.html").text
    assert after != before and base64.b64encode(after).decode() in page
    assert again["reason"] in page and "1 of 1 squares" in page


def test_use_is_counted_from_no_earlier_than_the_version_was_made(client: TestClient, made: dict[str, Any]) -> None:
    (version,) = client.get("/v1/venues/mall/radio-maps").json()["radio_maps"]
    assert made["drift"]["since"] == version["created"]


def test_a_version_that_does_not_exist_has_no_report(client: TestClient) -> None:
    for path in ("/v1/venues/mall/radio-maps/9", "/v1/venues/none/radio-maps/1"):
        for name in ("quality", "quality.png", "quality.html"):
            assert client.get(f"{path}/{name}").status_code == 404


def test_an_image_whose_pixels_cannot_be_read_is_left_out_of_the_report(client: TestClient) -> None:
    venue = surveyed(client, "undrawable")
    header = struct.pack(">IIBBBBB", 10, 10, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", b"no pixels"), (b"IEND", b"")]
    png = b"".join(
        struct.pack(">I4s", len(of), name) + of + struct.pack(">I", zlib.crc32(name + of)) for name, of in chunks
    )
    image = {"content": b"\x89PNG\r\n\x1a\n" + png, "headers": {"Content-Type": "image/png"}}
    assert client.put(f"/v1/venues/{venue}/floors/F1/image", **image).status_code == 204
    assert finished(client, f"/v1/venues/{venue}/radio-maps/1").json()["floors"]


def test_a_report_that_cannot_be_made_is_told_as_a_defect_and_not_tried_at_every_request(
    client: TestClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    venue, tried = surveyed(client, "broken"), list[str]()

    async def broken(*_: Any) -> None:
        tried.append("again")
        raise RuntimeError("of the inside")

    monkeypatch.setattr(WorkerProcesses, "run", broken)
    address, deadline = f"/v1/venues/{venue}/radio-maps/1/quality", time.monotonic() + PATIENCE_S
    while (answer := client.get(address)).status_code == 202 and time.monotonic() < deadline:
        pass
    assert answer.status_code == client.get(address).status_code == 500
    assert len(tried) == 1 and "inside" not in answer.text
