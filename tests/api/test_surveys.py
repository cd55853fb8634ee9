from __future__ import annotations

import errno
import gzip
import json
import lzma
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from httpx import Response
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from app.services import surveys
from app.services.worker_processes import WorkerProcesses
from app.survey.admission import MAKE_FLOOR
from app.wifi.radio_map_codec import decode_radio_map
from tests.api.survey_service import SURVEYS, SurveyService, left_behind, problem, survey_service
from tests.survey.test_unpacking import zipped
from tests.survey.traces import mac, walk

T = 1_700_000_000_000
CSV = f"floor,x,y,t,bssid,rssi\nF1,1,2,{T},{mac(1)},-50\nF2,1,2,{T},{mac(1)},-60\n"
JSON = {
    "floor": "F1",
    "fingerprints": [{"x": 1, "y": 2, "t": T, "readings": [{"bssid": mac(1), "rssi": -50, "frequency": 2412}]}],
}
NOTHING = {"surveys": 0, "fingerprints": 0, "radio_maps": 0, "revision": 1}
BOUNDARY = "----edge"


@pytest.fixture(scope="module", autouse=True)
def own_temporary_folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """So that what is left behind is this module's, whoever else uses the machine."""
    before, tempfile.tempdir = tempfile.tempdir, str(tmp_path_factory.mktemp("uploads"))
    yield
    tempfile.tempdir = before


@pytest.fixture
def service(tmp_path: Path, workers: WorkerProcesses) -> Iterator[SurveyService]:
    before = left_behind()
    with survey_service(f"sqlite:///{tmp_path / 'surveys.db'}", workers) as running:
        yield running
    assert left_behind() == before


@pytest.fixture(scope="module")
def lasting(tmp_path_factory: pytest.TempPathFactory, workers: WorkerProcesses) -> Iterator[SurveyService]:
    """One for tests that send much and must leave nothing."""
    database = tmp_path_factory.mktemp("surveys") / "surveys.db"
    with survey_service(f"sqlite:///{database}", workers) as running:
        yield running


def receipt(answer: Response) -> dict[str, Any]:
    assert answer.status_code == 201, answer.text
    return dict(answer.json())


@pytest.mark.parametrize("sent", ["json", "csv", "traces"])
def test_a_survey_lands_with_exactly_the_members_of_a_receipt(service: SurveyService, sent: str) -> None:
    answers = {
        "json": lambda: service.upload(json.dumps(JSON), "application/json; charset=utf-8"),
        "csv": lambda: service.upload(CSV, "text/csv; header=present"),
        "traces": lambda: service.upload_traces({"one.txt": walk()}),
    }
    got = receipt(answers[sent]())
    accepted = {"json": 1, "csv": 2, "traces": 10}[sent]
    assert got == {"survey": 1, "accepted": accepted, "rejected": [], "rejected_count": 0, "version": None}
    assert service.counts() == {"surveys": 1, "fingerprints": accepted, "radio_maps": 0, "revision": 1}


def test_bad_rows_are_rejected_by_number_and_good_rows_land(service: SurveyService) -> None:
    got = receipt(service.upload(CSV + f"F1,nan,2,{T},{mac(1)},-50\nF9,1,2,{T},{mac(1)},-50\n", "text/csv"))
    assert got["accepted"] == got["rejected_count"] == 2
    assert got["rejected"] == [
        {"item": 4, "reason": "x and y must be finite"},
        {"item": 5, "reason": f"the venue has no floor 'F9'; {MAKE_FLOOR}"},
    ]


def test_a_trace_is_named_by_its_file_up_to_the_first_dot_whatever_the_path_and_the_type(
    service: SurveyService,
) -> None:
    names = ["C:\\walks\\one.txt.xz", "/home/me/two.txt", "../../etc/three.txt", "vier-\u00fcber.txt", "five"]
    files = [
        ("files", (name, walk(), kind))
        for name, kind in zip(names, ["text/plain", "image/png", "", "x/y", "a/b"], strict=True)
    ]
    assert receipt(service.client.post(SURVEYS, params={"floor": "F1"}, files=files))["rejected"] == []

    async def walks() -> set[str]:
        found = [row async for chunk in service.wired.survey_rows.fingerprints([1]) for row in chunk]
        return {row[1] for row in found}

    assert service.call(walks) == {"one", "two", "three", "vier-\u00fcber", "five"}


def test_files_may_be_plain_gzip_xz_or_zip_and_damaged_ones_do_not_stop_the_others(service: SurveyService) -> None:
    traces = {
        "one.txt": walk(),
        "two.gz": gzip.compress(walk()),
        "three.xz": lzma.compress(walk()),
        "four.zip": zipped({"F1/five.txt": walk(), "six.txt.xz": lzma.compress(walk())}),
        "cut.xz": lzma.compress(walk())[:-50],
        "empty.txt": b"",
    }
    got = receipt(service.upload_traces(traces))
    assert got["accepted"] == 50
    assert [one["item"] for one in got["rejected"]] == ["cut.xz", "empty.txt"]


def test_publishing_makes_the_next_version_of_every_survey_the_active_one(service: SurveyService) -> None:
    assert receipt(service.upload(CSV, "text/csv"))["version"] is None
    assert receipt(service.upload_traces({"one.txt": walk()}, publish="true"))["version"] == 1
    assert receipt(service.upload(json.dumps(JSON), "application/json", publish="true"))["version"] == 2
    listed = service.client.get("/v1/venues/mall/radio-maps").json()
    assert [(one["version"], one["active"], one["surveys"]) for one in listed["radio_maps"]] == [
        (1, False, [1, 2]),
        (2, True, [1, 2, 3]),
    ]
    assert listed["active"] == 2
    assert listed["radio_maps"][1]["summary"]["floors"] == {"F1": 12, "F2": 1}
    active = service.call(service.wired.map_rows.active, "mall")
    radio_map = decode_radio_map(active.body)
    assert (active.revision, active.version, radio_map.version) == (3, 2, 2)
    assert radio_map.floors == ("F1", "F2") and int(radio_map.scans.sum()) == 13


def test_a_gzip_body_is_decompressed_and_a_bomb_is_stopped(service: SurveyService) -> None:
    headers = {"Content-Type": "text/csv", "Content-Encoding": "gzip"}
    for packed in (gzip.compress(CSV.encode()), gzip.compress(CSV[:30].encode()) + gzip.compress(CSV[30:].encode())):
        assert receipt(service.client.post(SURVEYS, content=packed, headers=headers))["accepted"] == 2
    before = service.counts()
    bomb = gzip.compress(b"\0" * 70_000_000, 1)
    for sent, status in ((bomb, 413), (gzip.compress(CSV.encode())[:-6], 422), (b"junk", 422), (b"", 422)):
        problem(service.client.post(SURVEYS, content=sent, headers=headers), status)
    problem(service.client.post(SURVEYS, content=b"", headers={**headers, "Content-Encoding": "br"}), 415)
    assert service.counts() == before


def multipart(*parts: bytes, end: bytes = b"--\r\n") -> bytes:
    edge = b"--" + BOUNDARY.encode()
    return b"".join(edge + b"\r\n" + part + b"\r\n" for part in parts) + edge + end


def part(name: str = "files", content: bytes = b"x", filename: str | None = "a.txt") -> bytes:
    disposition = f'Content-Disposition: form-data; name="{name}"'
    if filename is not None:
        disposition += f'; filename="{filename}"'
    return disposition.encode() + b"\r\n\r\n" + content


MULTIPART = f"multipart/form-data; boundary={BOUNDARY}"
GOOD_PART = part(content=walk())
BAD_UPLOADS: dict[str, tuple[bytes | str, str, dict[str, str], int, str | None]] = {
    "multipart without a floor": (multipart(GOOD_PART), MULTIPART, {}, 422, "floor"),
    "an unknown floor": (multipart(GOOD_PART), MULTIPART, {"floor": "F9"}, 404, "floor"),
    "an unknown floor of a body": (json.dumps({**JSON, "floor": "F9"}), "application/json", {}, 404, "floor"),
    "an unknown floor for a CSV": (CSV, "text/csv", {"floor": "F9"}, 404, "floor"),
    "multipart that is cut off": (multipart(GOOD_PART)[:-40], MULTIPART, {"floor": "F1"}, 422, "files"),
    "multipart without its last edge": (multipart(GOOD_PART, end=b"\r\n"), MULTIPART, {"floor": "F1"}, 422, "files"),
    "another boundary": (multipart(GOOD_PART), f"{MULTIPART}x", {"floor": "F1"}, 422, "files"),
    "a boundary without end": (multipart(GOOD_PART), f"{MULTIPART}{'x' * 8000}", {"floor": "F1"}, 422, "files"),
    "no boundary": (multipart(GOOD_PART), "multipart/form-data", {"floor": "F1"}, 422, "files"),
    "no part": (multipart(), MULTIPART, {"floor": "F1"}, 422, "files"),
    "an empty multipart body": (b"", MULTIPART, {"floor": "F1"}, 422, "files"),
    "empty parts": (multipart(part(content=b"")), MULTIPART, {"floor": "F1"}, 422, "files"),
    "a part of another name": (
        multipart(GOOD_PART, part("floor", b"F1", None)), MULTIPART, {"floor": "F1"}, 422, "floor"
    ),
    "a part without headers": (multipart(b"\r\n\r\nx"), MULTIPART, {"floor": "F1"}, 422, None),
    "garbage as a trace": (multipart(part(content=bytes(range(256)) * 9)), MULTIPART, {"floor": "F1"}, 422, "files"),
    "a damaged zip": (multipart(part(content=b"PK\x03\x04junk")), MULTIPART, {"floor": "F1"}, 422, "files"),
    "a walk without a place": (
        multipart(part(content=b"1574559495000\tTYPE_WAYPOINT\tnan\tnan\n")), MULTIPART, {"floor": "F1"}, 422, "files"
    ),
    "NaN coordinates in a CSV": (CSV.splitlines()[0] + f"\nF1,nan,2,{T},{mac(1)},-50\n", "text/csv", {}, 422, "row 2"),
    "a CSV of another kind": ("a,b,c\n1,2,3\n", "text/csv", {}, 422, "floor"),
    "an empty CSV": ("", "text/csv", {}, 422, "floor"),
    "a CSV of a header alone": (CSV.splitlines()[0], "text/csv", {}, 422, None),
    "binary garbage as a CSV": (bytes(range(256)) * 99, "text/csv", {}, 422, "floor"),
    "no JSON": (b"{", "application/json", {}, 422, None),
    "binary garbage as JSON": (bytes(range(256)) * 99, "application/json", {}, 422, None),
    "NaN in JSON": (
        json.dumps({**JSON, "fingerprints": [{"x": float("nan")}]}),
        "application/json",
        {},
        422,
        "fingerprints[0]",
    ),
    "an unknown member": (json.dumps({**JSON, "colour": 1}), "application/json", {}, 422, "colour"),
    "no fingerprint": (json.dumps({**JSON, "fingerprints": []}), "application/json", {}, 422, "fingerprints"),
    "a fingerprint off the floor": (
        json.dumps({**JSON, "fingerprints": [{**JSON["fingerprints"][0], "x": 1e9}]}),  # type: ignore[dict-item]
        "application/json", {}, 422, "fingerprints[0]",
    ),
    "nested without end": (b"[" * 50_000, "application/json", {}, 422, None),
    "another media type": (b"<a/>", "application/xml", {}, 415, None),
    "a form": (b"a=b", "application/x-www-form-urlencoded", {}, 415, None),
    "an odd publish": (CSV, "text/csv", {"publish": "perhaps"}, 422, "publish"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD_UPLOADS)
def test_an_upload_that_is_of_no_use_is_refused_by_its_field_and_leaves_nothing(
    lasting: SurveyService, name: str
) -> None:
    content, kind, query, status, field = BAD_UPLOADS[name]
    before, folders = lasting.counts(), left_behind()
    for publish in {"publish": query.get("publish", "false")}, {"publish": query.get("publish", "true")}:
        refused = problem(lasting.upload(content, kind, **{**query, **publish}), status)
        assert refused.get("field") == field
        assert len(refused["detail"]) > 10
    assert lasting.counts() == before == NOTHING
    assert left_behind() == folders


@settings(deadline=None, max_examples=25, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.binary(max_size=200), st.integers(0, 300), st.sampled_from(["text/csv", "application/json", MULTIPART]))
def test_no_damage_to_a_body_is_a_fault_of_the_service(
    lasting: SurveyService, damage: bytes, at: int, kind: str
) -> None:
    whole = {"text/csv": CSV.encode(), "application/json": json.dumps(JSON).encode()}.get(kind, multipart(GOOD_PART))
    answer = lasting.upload(damage + whole[at:], kind, floor="F1")
    assert answer.status_code in (201, 422)
    if answer.status_code == 201:
        assert answer.json()["accepted"] >= 1


def test_a_venue_that_is_none_is_not_found_and_a_key_is_needed(service: SurveyService) -> None:
    for path in ("surveys", "radio-maps"):
        answer = service.client.post(f"/v1/venues/nowhere/{path}", json={"surveys": [1]})
        problem(answer, 404)
    answer = service.client.post(SURVEYS, content=CSV, headers={"Content-Type": "text/csv", "Authorization": "x"})
    problem(answer, 401)
    assert service.counts() == NOTHING


def test_a_body_beyond_the_limit_is_refused(tmp_path: Path, workers: WorkerProcesses) -> None:
    with survey_service(f"sqlite:///{tmp_path / 'small.db'}", workers, limit_bytes=10_000) as service:
        row = f"F1,1,2,{T},{mac(1)},-50\n"
        problem(service.upload(CSV + row * 400, "text/csv"), 413)
        problem(service.upload_traces({"a": b"x" * 20_000}), 413)
        assert receipt(service.upload(CSV + row * 100, "text/csv"))["accepted"] == 3
        assert service.counts()["surveys"] == 1


def test_with_respond_async_a_task_tells_the_same_receipt_in_the_end(service: SurveyService) -> None:
    headers = {"Content-Type": "text/csv", "Prefer": "wait=1, respond-async"}
    answer = service.client.post(SURVEYS, params={"publish": "true"}, content=CSV, headers=headers)
    assert answer.status_code == 202
    assert answer.headers["preference-applied"] == "respond-async"
    assert answer.json() == {"task": answer.headers["location"]}
    task = ended(service, answer.json()["task"])
    assert task == {
        "task": answer.json()["task"],
        "status": "done",
        "receipt": {"survey": 1, "accepted": 2, "rejected": [], "rejected_count": 0, "version": 1},
        "problem": None,
    }
    assert service.counts() == {"surveys": 1, "fingerprints": 2, "radio_maps": 1, "revision": 2}


def test_a_task_that_fails_tells_the_problem_that_the_request_would_have_had(service: SurveyService) -> None:
    header = CSV.splitlines()[0]
    sent = header + f"\nF1,nan,2,{T},{mac(1)},-50\n"
    at_once = problem(service.upload(sent, "text/csv"), 422)
    answer = service.client.post(SURVEYS, content=sent, headers={"Content-Type": "text/csv", "Prefer": "respond-async"})
    task = ended(service, answer.json()["task"])
    assert (task["status"], task["receipt"]) == ("failed", None)
    assert task["problem"] == at_once
    assert service.counts() == NOTHING


def out_of_space(*_: object) -> None:
    raise OSError(errno.ENOSPC, "No space left on device")


def test_a_full_disk_is_told_in_the_same_words_by_a_request_and_by_a_task(
    service: SurveyService, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(surveys, "read_upload", out_of_space)
    at_once = service.upload(CSV, "text/csv")
    assert "disk of the service is full" in problem(at_once, 503)["detail"]
    answer = service.client.post(SURVEYS, content=CSV, headers={"Content-Type": "text/csv", "Prefer": "respond-async"})
    task = ended(service, answer.json()["task"])
    assert (task["status"], task["problem"]) == ("failed", at_once.json())
    assert service.counts() == NOTHING


def test_what_is_wrong_on_the_face_of_it_is_refused_at_once_even_with_respond_async(service: SurveyService) -> None:
    headers = {"Content-Type": MULTIPART, "Prefer": "respond-async"}
    problem(service.client.post(SURVEYS, content=multipart(GOOD_PART), headers=headers), 422)
    problem(service.client.get("/v1/tasks/none"), 404)


def ended(service: SurveyService, address: str) -> dict[str, Any]:
    """The task once it has ended."""

    async def wait() -> None:
        for running in tuple(service.wired.tasks.running):
            await running

    service.call(wait)
    answer = service.client.get(address)
    assert answer.status_code == 200
    return dict(answer.json())
