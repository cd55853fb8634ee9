from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import update

from app.floorplan.georeference import Georeference
from app.services.worker_processes import WorkerProcesses
from app.storage.tables import floors
from tests.api.survey_service import KEY, SurveyService, survey_service
from tests.survey.traces import mac

PATH = "/v2/geosubmit"


@pytest.fixture
def service(tmp_path: Path, workers: WorkerProcesses) -> Iterator[SurveyService]:
    with survey_service(f"sqlite:///{tmp_path / 'reports.db'}", workers) as running:
        yield running


def report(x_m: float = 20.0, **position: Any) -> dict[str, Any]:
    latitude, longitude = Georeference(30.0, 120.0, 0.0).to_wgs84(x_m, 30.0)
    points = [{"macAddress": mac(n), "signalStrength": -50, "channel": 6} for n in range(3)]
    place = {"latitude": latitude, "longitude": longitude, **position}
    return {"timestamp": 1_405_602_028_568, "position": place, "wifiAccessPoints": points}


def stored(service: SurveyService) -> list[tuple[str, float]]:
    """Floor and x of every fingerprint."""

    async def read() -> list[tuple[str, float]]:
        rows = service.wired.survey_rows
        ids = await rows.ids(1)
        return [
            (row[0], round(row[3], 2)) for survey in ids async for chunk in rows.fingerprints([survey]) for row in chunk
        ]

    return list(service.call(read))


def test_reports_are_answered_as_the_original_does_and_land_as_a_survey(service: SurveyService) -> None:
    answer = service.client.post(PATH, json={"items": [report(20.0), report(30.0, floor="F2")]})
    assert (answer.status_code, answer.json()) == (200, {})
    assert stored(service) == [("F1", 20.0), ("F2", 30.0)]
    assert service.counts() == {"surveys": 1, "fingerprints": 2, "radio_maps": 0, "revision": 1}


def test_they_enter_the_radio_map_with_the_next_version(service: SurveyService) -> None:
    service.client.post(PATH, json={"items": [report()]})
    answer = service.client.post("/v1/venues/mall/radio-maps", json={"surveys": [1]})
    assert answer.json()["summary"]["fingerprints"] == 1


def test_bad_reports_are_left_out_and_the_others_land(service: SurveyService) -> None:
    items = [None, report(5000.0), report(), {"position": 7}, report(latitude="north")]
    assert service.client.post(PATH, json={"items": items}).json() == {}
    assert stored(service) == [("F1", 20.0)]


def test_a_report_is_not_placed_on_a_floor_of_which_it_is_not_known_how_it_is_turned(service: SurveyService) -> None:
    async def forget() -> None:
        async with service.wired.engine.begin() as connection:
            await connection.execute(update(floors).where(floors.c.floor == "F1").values(rotation_rad=None))

    service.call(forget)
    assert service.client.post(PATH, json={"items": [report(20.0), report(30.0, floor="F1")]}).json() == {}
    assert stored(service) == [("F2", 20.0)]


def test_reports_of_which_none_can_be_used_leave_nothing(service: SurveyService) -> None:
    for items in ([], [report(5000.0)]):
        answer = service.client.post(PATH, json={"items": items})
        assert (answer.status_code, answer.json()) == (200, {})
    assert service.counts()["surveys"] == 0


@pytest.mark.parametrize(
    "sent", [b"", b"{", b"[]", b"null", b'{"items":{}}', b'{"items":null}', b"\xff", b"[" * 50_000]
)
def test_a_body_that_cannot_be_read_is_a_parse_error(service: SurveyService, sent: bytes) -> None:
    answer = service.client.post(PATH, content=sent)
    assert answer.status_code == 400
    error = answer.json()["error"]
    assert (error["code"], error["errors"][0]["reason"]) == (400, "parseError")


def test_the_key_may_come_in_the_query(service: SurveyService) -> None:
    for key, status in ((KEY, 200), ("wrong", 401)):
        answer = service.client.post(PATH, params={"key": key}, json={"items": []}, headers={"Authorization": ""})
        assert answer.status_code == status
        assert answer.json() == {} or answer.json()["error"]["errors"][0]["reason"] == "keyInvalid"
