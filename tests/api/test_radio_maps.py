from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from app.services.worker_processes import WorkerProcesses
from app.wifi.radio_map_codec import decode_radio_map
from tests.api.survey_service import CLOCK_MS, SurveyService, problem, survey_service
from tests.survey.traces import mac

MAPS, ACTIVE = "/v1/venues/mall/radio-maps", "/v1/venues/mall/radio-map"


@pytest.fixture
def service(tmp_path: Path, workers: WorkerProcesses) -> Iterator[SurveyService]:
    """With three surveys of one fingerprint each; the first two make version 1."""
    with survey_service(f"sqlite:///{tmp_path / 'maps.db'}", workers) as running:
        for number, publish in ((1, "false"), (2, "true"), (3, "false")):
            text = f"floor,x,y,t,bssid,rssi\nF1,{10 * number},2,{CLOCK_MS},{mac(number)},-50\n"
            assert running.upload(text, "text/csv", publish=publish).status_code == 201
        yield running


def active(service: SurveyService) -> Any:
    return service.call(service.wired.map_rows.active, "mall")


def test_a_version_is_built_of_chosen_surveys_and_is_not_active(service: SurveyService) -> None:
    answer = service.client.post(MAPS, json={"surveys": [3, 1, 3]})
    assert answer.status_code == 201
    summary = {"fingerprints": 2, "reference_points": 2, "access_points": 2, "beacons": 0, "floors": {"F1": 2}}
    built = {"version": 2, "active": False, "created": CLOCK_MS, "surveys": [1, 3], "summary": summary}
    assert answer.json() == built
    listed = service.client.get(MAPS).json()
    assert listed["active"] == 1 and listed["radio_maps"][1] == built
    assert (active(service).version, active(service).revision) == (1, 2)


def test_any_version_can_be_made_active_and_an_older_one_again(service: SurveyService) -> None:
    service.client.post(MAPS, json={"surveys": [3]})
    for version, point, revision in ((2, 30.0, 3), (1, 10.0, 4), (2, 30.0, 5)):
        answer = service.client.put(ACTIVE, json={"version": version})
        assert (answer.status_code, answer.json()) == (200, {"version": version})
        radio_map = decode_radio_map(active(service).body)
        assert (radio_map.version, radio_map.xy_m[0, 0]) == (version, point)
        assert active(service).revision == revision


@pytest.mark.parametrize(
    ("method", "path", "body", "status", "field"),
    [
        ("POST", MAPS, {"surveys": [1], "colour": 2}, 422, "colour"),
        ("POST", MAPS, {"surveys": []}, 422, "surveys"),
        ("POST", MAPS, {"surveys": [1, 99]}, 422, "surveys[1]"),
        ("POST", MAPS, {"surveys": ["1"]}, 422, "surveys[0]"),
        ("POST", MAPS, {"surveys": [1 << 63]}, 422, "surveys[0]"),
        ("POST", MAPS, {}, 422, "surveys"),
        ("PUT", ACTIVE, {"version": 1, "force": True}, 422, "force"),
        ("PUT", ACTIVE, {"version": 0}, 422, "version"),
        ("PUT", ACTIVE, {"version": True}, 422, "version"),
        ("PUT", ACTIVE, {"version": 9}, 404, None),
        ("PUT", "/v1/venues/nowhere/radio-map", {"version": 1}, 404, None),
    ],
)
def test_a_request_that_cannot_be_met_is_refused_by_its_field_and_changes_nothing(
    service: SurveyService, method: str, path: str, body: Any, status: int, field: str | None
) -> None:
    before = service.counts()
    assert problem(service.client.request(method, path, json=body), status).get("field") == field
    assert service.counts() == before
    assert active(service).version == 1


def test_a_body_that_is_not_json_is_refused(service: SurveyService) -> None:
    problem(service.client.put(ACTIVE, content=b"{", headers={"Content-Type": "application/json"}), 422)
    problem(service.client.put(ACTIVE, content=b"1", headers={"Content-Type": "text/plain"}), 415)


def test_a_venue_without_a_map_lists_none(service: SurveyService, tmp_path: Path, workers: WorkerProcesses) -> None:
    with survey_service(f"sqlite:///{tmp_path / 'fresh.db'}", workers) as fresh:
        assert fresh.client.get(MAPS).json() == {"active": None, "radio_maps": []}
    problem(service.client.get("/v1/venues/nowhere/radio-maps"), 404)
