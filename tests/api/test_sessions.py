from __future__ import annotations

import gzip
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import ormsgpack
import pytest
import zstandard

from tests.api.phone_service import LIMIT_BYTES, PhoneService, phone_service
from tests.odometer import NOT_FINITE_BSSID, RAISE_BSSID

T0 = 1_573_190_000_000
HEARD = {"bssid": "a8:0c:ca:03:9d:d7", "rssi": -49}


@pytest.fixture
def service(tmp_path: Path) -> Iterator[PhoneService]:
    with phone_service(f"sqlite:///{tmp_path / 'phones.db'}") as made:
        yield made


def batch(sequence: int, readings: list[dict[str, Any]] | None = None, **more: Any) -> dict[str, Any]:
    end = T0 + 1000 * (sequence + 1)
    times = [end - 900 + 100 * i for i in range(10)]
    columns = {"t": times, "x": [0.0] * 10, "y": [0.0] * 10, "z": [9.8] * 10}
    scan = [{"t": end - 500, "readings": [HEARD] if readings is None else readings}]
    return {"sequence": sequence, "end": end, "accelerometer": columns, "wifi": scan, **more}


def everything(service: PhoneService, session: str) -> tuple[bytes, bytes]:
    """What a session answers about itself."""
    path = f"/v1/sessions/{session}"
    return service.client.get(f"{path}/fix").content, service.client.get(f"{path}/track").content


@pytest.mark.parametrize("session", ["0" * 32, "x", "%00", "é", "a" * 500, "..%2f"])
def test_an_unknown_session_is_not_found(service: PhoneService, session: str) -> None:
    path = f"/v1/sessions/{session}"
    answers = [service.client.get(f"{path}/{leaf}") for leaf in ("fix", "track", "events")]
    answers += [service.client.post(f"{path}/batches", json={"sequence": 0}), service.client.delete(path)]
    assert [answer.status_code for answer in answers] == [404] * 5


def test_before_the_first_batch_a_session_answers_that_it_knows_nothing(service: PhoneService) -> None:
    session = service.open(alert_limit=7.0)
    fix = service.client.get(f"/v1/sessions/{session}/fix").json()
    assert (fix["sequence"], fix["t"], fix["position"], fix["accuracy"]) == (-1, None, None, None)
    assert fix["integrity"]["flag"] == "initialising" and fix["integrity"]["alert_limit"] == 7.0


def test_a_fix_has_the_fields_of_the_contract(service: PhoneService) -> None:
    session = service.open()
    fix = service.fix(session, batch(0))
    assert fix == {
        "session": session,
        "sequence": 0,
        "t": T0 + 1000,
        "dropped": 0,
        "gap": False,
        "position": {"x": 1.0, "y": 10.0, "floor": "F1", **{k: fix["position"][k] for k in ("latitude", "longitude")}},
        "accuracy": 2.5,
        "covariance": [[1.0, 0.0], [0.0, 1.0]],
        "heading": 0.5,
        "speed": 1.25,
        "steps": 1,
        "motion": "walking",
        "carrying": "handheld",
        "integrity": {
            "flag": "nominal",
            "usable": True,
            "if1": 0,
            "if2": 0,
            "if3": 0,
            "statistic": 1.0,
            "threshold": 30.0,
            "protection_level": 6.0,
            "alert_limit": 10.0,
            "risk": 0.01,
            "excluded": [],
        },
    }
    assert fix["position"]["latitude"] == pytest.approx(30 + 10 / 111319.49)
    assert service.client.get(f"/v1/sessions/{session}/fix").json() == fix


def test_a_floor_without_georeference_has_no_latitude(service: PhoneService) -> None:
    position = service.fix(service.open(floor="F2"), batch(0))["position"]
    assert position["latitude"] is None and position["longitude"] is None


def test_an_empty_batch_keeps_alive_and_repeats_the_time(service: PhoneService) -> None:
    session = service.open()
    assert service.fix(session, {"sequence": 0})["t"] is None
    assert service.fix(session, batch(1))["t"] == T0 + 2000
    assert service.fix(session, {"sequence": 2})["t"] == T0 + 2000
    assert service.fix(session, {"sequence": 3, "end": T0 + 9000})["t"] == T0 + 9000


def test_a_batch_sent_again_gets_the_same_bytes_and_changes_nothing(service: PhoneService) -> None:
    session = service.open()
    first = service.send(session, batch(0))
    again = service.send(session, batch(0))
    other = service.send(session, {"sequence": 0})
    assert again.content == other.content == first.content
    assert "Idempotent-Replayed" not in first.headers
    assert again.headers["Idempotent-Replayed"] == other.headers["Idempotent-Replayed"] == "true"
    assert service.fix(session, batch(1))["position"]["x"] == 2.0


def test_a_gap_is_accepted_and_flagged(service: PhoneService) -> None:
    session = service.open()
    assert [service.fix(session, batch(n))["gap"] for n in (3, 4, 9)] == [True, False, True]


def test_an_older_batch_is_a_conflict_whether_it_was_stored_or_not(service: PhoneService) -> None:
    session = service.open()
    for sequence in (0, 2):
        service.fix(session, batch(sequence))
    before = everything(service, session)
    assert [service.send(session, batch(n)).status_code for n in (0, 1)] == [409, 409]
    assert everything(service, session) == before


@pytest.mark.parametrize(
    ("stream", "field"),
    [
        ({"gyroscope": {"t": [T0 - 1500], "x": [0], "y": [0], "z": [0]}, "end": T0 + 2000}, "gyroscope.t[0]"),
        ({"wifi": [{"t": T0 - 1500, "readings": []}]}, "wifi[0].t"),
        ({"end": T0 - 1500}, "end"),
        ({"end": T0 + 2 * 3_600_000}, "end"),
        ({"barometer": {"t": [T0 + 2 * 3_600_000], "pressure": [1000]}}, "barometer.t[0]"),
    ],
)
def test_time_that_does_not_follow_on_the_session_is_refused_by_name(
    service: PhoneService, stream: dict[str, Any], field: str
) -> None:
    session = service.open()
    service.fix(session, batch(0))
    before = everything(service, session)
    answer = service.send(session, {"sequence": 1, **stream})
    assert answer.status_code == 422 and field in answer.text
    assert everything(service, session) == before


def test_samples_that_are_a_little_late_are_taken(service: PhoneService) -> None:
    session = service.open()
    service.fix(session, batch(0))
    late = {"t": [T0 - 900], "x": [0], "y": [0], "z": [0]}
    assert service.fix(session, {"sequence": 1, "accelerometer": late, "end": T0 + 1500})["t"] == T0 + 1500


@pytest.mark.parametrize("year_ms", [86_400_000, T0, 4_102_444_700_000])
def test_walks_of_any_year_replay_alike(service: PhoneService, year_ms: int) -> None:
    session = service.open()
    for sequence in range(3):
        fix = service.fix(session, {"sequence": sequence, "end": year_ms + 1000 * sequence})
        assert fix["t"] == year_ms + 1000 * sequence


def test_json_and_messagepack_plain_and_compressed_lead_to_the_same_fix(service: PhoneService) -> None:
    as_json, as_msgpack = json.dumps(batch(0)).encode(), ormsgpack.packb(batch(0))
    fixes = []
    for kind, sent in (("application/json", as_json), ("application/msgpack", as_msgpack)):
        for encoding, pack in (("identity", bytes), ("gzip", gzip.compress), ("zstd", zstandard.compress)):
            headers = {"Content-Type": kind, "Content-Encoding": encoding}
            path = f"/v1/sessions/{service.open()}/batches"
            answer = service.client.post(path, content=pack(sent), headers=headers)
            assert answer.status_code == 200, answer.text
            fixes.append({**answer.json(), "session": ""})
    assert fixes == [fixes[0]] * 6


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({"Content-Type": "text/plain"}, 415),
        ({"Content-Type": "application/json", "Content-Encoding": "br"}, 415),
        ({"Content-Type": "application/json", "Content-Encoding": "gzip"}, 422),
        ({"Content-Type": "application/json", "Content-Encoding": "zstd"}, 422),
    ],
)
def test_what_cannot_be_read_is_refused(service: PhoneService, headers: dict[str, str], status: int) -> None:
    session = service.open()
    path = f"/v1/sessions/{session}/batches"
    assert service.client.post(path, content=b'{"sequence":0}', headers=headers).status_code == status


def test_a_body_beyond_the_limit_is_refused_however_it_is_packed(service: PhoneService) -> None:
    path = f"/v1/sessions/{service.open()}/batches"
    plain = b'{"sequence":0,"x":"' + b"a" * LIMIT_BYTES + b'"}'
    for encoding, sent in (("identity", plain), ("gzip", gzip.compress(plain)), ("zstd", zstandard.compress(plain))):
        headers = {"Content-Type": "application/json", "Content-Encoding": encoding}
        assert service.client.post(path, content=sent, headers=headers).status_code == 413


@pytest.mark.parametrize("bssid", [NOT_FINITE_BSSID, RAISE_BSSID])
def test_a_defect_in_a_method_leaves_the_session_as_it_was(service: PhoneService, bssid: int) -> None:
    session = service.open()
    service.fix(session, batch(0))
    before = everything(service, session)
    bad = batch(1, [{"bssid": f"{bssid:012x}", "rssi": -50}])
    assert service.send(session, bad).status_code == 500
    assert everything(service, session) == before
    assert service.fix(session, batch(1))["position"]["x"] == 2.0


def test_dropped_readings_are_counted_in_the_fix(service: PhoneService) -> None:
    readings: list[dict[str, Any]] = [HEARD, {"bssid": None, "rssi": -1}, {**HEARD, "rssi": 99}]
    assert service.fix(service.open(), batch(0, readings))["dropped"] == 2


def test_a_session_ends_some_hours_after_its_last_batch_and_is_told_from_an_unknown_one(service: PhoneService) -> None:
    session = service.open()
    service.wired.clock_ms[0] += 11 * 3_600_000
    service.fix(session, batch(0))
    service.wired.clock_ms[0] += 11 * 3_600_000
    service.fix(session, batch(1))
    service.wired.clock_ms[0] += 13 * 3_600_000
    for emptied in (1, 0):
        path = f"/v1/sessions/{session}"
        answers = [service.client.get(f"{path}/{leaf}") for leaf in ("fix", "track", "events")]
        assert [answer.status_code for answer in answers] == [410] * 3
        assert service.send(session, batch(2)).status_code == 410
        assert service.call(service.wired.tracking.purge) == emptied
    service.wired.clock_ms[0] += 31 * 86_400_000
    service.call(service.wired.tracking.purge)
    assert service.send(session, batch(2)).status_code == 404


def test_an_erased_session_is_unknown_and_leaves_nothing(service: PhoneService) -> None:
    session, other = service.open(), service.open()
    for one in (session, other):
        service.fix(one, batch(0))
    assert service.client.delete(f"/v1/sessions/{session}").status_code == 204
    assert service.client.delete(f"/v1/sessions/{session}").status_code == 404
    assert service.client.get(f"/v1/sessions/{session}/track").status_code == 404
    assert service.send(session, batch(1)).status_code == 404
    assert service.fix(other, batch(1))["position"]["x"] == 2.0


def test_a_track_comes_in_pages(service: PhoneService) -> None:
    session = service.open()
    sent = [service.fix(session, batch(n)) for n in range(7)]
    path, pages = f"/v1/sessions/{session}/track", []
    cursor: dict[str, str] = {}
    while True:
        page = service.client.get(path, params={"limit": 3, **cursor}).json()
        pages.append(page["fixes"])
        if page["next"] is None:
            break
        cursor = {"cursor": page["next"]}
    assert [len(page) for page in pages] == [3, 3, 1]
    assert [fix for page in pages for fix in page] == sent
    part = service.client.get(path, params={"from": T0 + 2000, "to": T0 + 4000}).json()
    assert part["fixes"] == sent[1:4] and part["next"] is None


@pytest.mark.parametrize(
    "params",
    [{"smoothed": "perhaps"}, {"limit": 0}, {"limit": 10**9}, {"from": "x"}, {"to": 10**30}, {"cursor": "x"}],
)
def test_a_track_that_cannot_be_given_is_refused(service: PhoneService, params: dict[str, Any]) -> None:
    answer = service.client.get(f"/v1/sessions/{service.open()}/track", params=params)
    assert answer.status_code == 422 and next(iter(params)) in answer.text


def test_a_track_as_geojson_is_in_longitude_and_latitude(service: PhoneService) -> None:
    session = service.open()
    service.fix(session, {"sequence": 0})
    position = service.fix(session, batch(1))["position"]
    answer = service.client.get(f"/v1/sessions/{session}/track", headers={"Accept": "application/geo+json"})
    assert answer.headers["Content-Type"] == "application/geo+json"
    unknown, known = answer.json()["features"]
    assert unknown["geometry"] is None
    assert known["geometry"] == {"type": "Point", "coordinates": [position["longitude"], position["latitude"]]}
    assert known["properties"]["flag"] == "nominal"
    refused = service.client.get(f"/v1/sessions/{session}/track", headers={"Accept": "application/geo+json;q=0"})
    assert refused.headers["Content-Type"] == "application/json"


def test_without_a_key_nothing_is_answered(service: PhoneService) -> None:
    session = service.open()
    service.client.headers.pop("Authorization")
    path = f"/v1/sessions/{session}"
    answers = [service.client.get(f"{path}/{leaf}") for leaf in ("fix", "track", "events")]
    answers += [service.client.post(f"{path}/{leaf}", json={"sequence": 0}) for leaf in ("batches", "tickets")]
    assert [answer.status_code for answer in answers] == [401] * 5
