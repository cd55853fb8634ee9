"""Whatever a batch holds: a refusal that names the field, and a session that is exactly as it was."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Iterator
from typing import Any

import ormsgpack
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.api.phone_service import PhoneService, phone_service

T0 = 1_573_190_000_000
N = 12
AXES = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[PhoneService]:
    with phone_service(f"sqlite:///{tmp_path_factory.mktemp('bad') / 'phones.db'}") as made:
        yield made


@pytest.fixture(scope="module")
def session(service: PhoneService) -> str:
    opened = service.open()
    service.fix(opened, good(0))
    return opened


def good(sequence: int) -> dict[str, Any]:
    start = T0 + 1000 * sequence
    times = [start + 50 * i for i in range(N)]
    body: dict[str, Any] = {"sequence": sequence, "end": start + 1000}
    body |= {name: {"t": list(times), "x": [0.1] * N, "y": [0.2] * N, "z": [0.3] * N} for name in AXES}
    body["barometer"] = {"t": list(times), "pressure": [1013.25] * N}
    reading = {"bssid": "a8:0c:ca:03:9d:d7", "rssi": -49, "frequency": 2422, "seen": start}
    body["wifi"] = [{"t": start, "readings": [dict(reading)]}, {"t": start + 500, "readings": [dict(reading)] * 2}]
    beacon = {"id": "uuid:1:2", "rssi": -82, "tx_power": -65}
    body["bluetooth"] = [{"t": start, "readings": [dict(beacon)]}, {"t": start + 500, "readings": [dict(beacon)]}]
    return body


def nested(depth: int) -> list[Any]:
    inner: list[Any] = []
    for _ in range(depth):
        inner = [inner]
    return inner


NOT_NUMBERS: tuple[Any, ...] = (None, True, "", "12", "\0", "😀", "A" * 1000, [], {}, nested(60), {"t": {"t": {}}})
NOT_FINITE: tuple[Any, ...] = (math.nan, math.inf, -math.inf)
NOT_PLAUSIBLE: tuple[Any, ...] = (*NOT_FINITE, 1e308, -1e308, 2**63, -(2**63))
COLUMNS = [(name, axis) for name in AXES for axis in "txyz"] + [("barometer", "t"), ("barometer", "pressure")]
SCAN_NUMBERS = [
    ("wifi", "rssi", NOT_NUMBERS),
    ("wifi", "seen", NOT_NUMBERS[1:]),  # null is a seen that is missing
    ("wifi", "frequency", NOT_NUMBERS[1:]),
    ("bluetooth", "rssi", NOT_NUMBERS),
    ("bluetooth", "tx_power", NOT_NUMBERS[1:]),
]


@st.composite
def bad_batches(draw: st.DrawFn) -> tuple[dict[str, Any], str]:
    """A batch with one fault, and what the refusal must mention."""
    body = good(1)
    name, axis = draw(st.sampled_from(COLUMNS))
    index = draw(st.integers(0, N - 1))
    match draw(st.sampled_from(("value", "length", "column", "stream", "order", "scan", "scans", "when", "top"))):
        case "value":
            implausible = NOT_FINITE if axis == "pressure" else NOT_PLAUSIBLE
            body[name][axis][index] = draw(st.sampled_from(NOT_NUMBERS + implausible))
            return body, f"{name}.{axis}[{index}]"
        case "length":
            length = draw(st.integers(0, 40).filter(lambda n: n != N))
            body[name][axis] = [T0 + 1000.0 if axis == "t" else 0.0 if axis != "pressure" else 1000.0] * length
            return body, name
        case "column":
            body[name][axis] = draw(st.sampled_from([junk for junk in NOT_NUMBERS if junk != []]))
            return body, f"{name}.{axis}"
        case "stream":
            body[name] = draw(st.sampled_from([junk for junk in NOT_NUMBERS if junk is not None]))
            return body, name
        case "order":
            i = max(index, 1)
            body[name]["t"][i] = body[name]["t"][i - 1] - draw(st.integers(1, 10**13))
            return body, f"{name}.t[{i}]"
        case "scan":
            stream, part, junk = draw(st.sampled_from(SCAN_NUMBERS))
            body[stream][1]["readings"][0] = {**body[stream][1]["readings"][0], part: draw(st.sampled_from(junk))}
            return body, f"{stream}[1].readings[0].{part}"
        case "scans":
            stream = draw(st.sampled_from(("wifi", "bluetooth")))
            body[stream][1] = draw(st.sampled_from(NOT_NUMBERS))
            return body, f"{stream}[1]"
        case "when":
            stream = draw(st.sampled_from(("wifi", "bluetooth")))
            body[stream][1]["t"] = draw(st.sampled_from((*NOT_NUMBERS, *NOT_PLAUSIBLE, T0, 0, -1)))
            return body, f"{stream}[1].t"
        case _:
            field = draw(st.sampled_from(("sequence", "end")))
            junk = (*NOT_NUMBERS[1:], *NOT_PLAUSIBLE) if field == "end" else (*NOT_NUMBERS, *NOT_PLAUSIBLE, -1, 0.5)
            body[field] = draw(st.sampled_from(junk))
            return body, field


def snapshot(service: PhoneService, session: str) -> tuple[bytes, bytes, bytes | None]:
    """Fix, track and stored state of a session."""
    path = f"/v1/sessions/{session}"
    state = service.call(service.wired.rows.read_state, session, 0)
    return service.client.get(f"{path}/fix").content, service.client.get(f"{path}/track").content, state


@given(bad_batches(), st.booleans())
@settings(max_examples=300, deadline=None)
def test_a_bad_batch_is_refused_by_field_and_changes_nothing(
    service: PhoneService, session: str, bad: tuple[dict[str, Any], str], packed: bool
) -> None:
    body, field = bad
    sent = ormsgpack.packb(body) if packed else json.dumps(body).encode()
    headers = {"Content-Type": "application/msgpack" if packed else "application/json"}
    before = snapshot(service, session)
    answer = service.client.post(f"/v1/sessions/{session}/batches", content=sent, headers=headers)
    assert 400 <= answer.status_code < 500, answer.text
    assert field in answer.text
    assert snapshot(service, session) == before


@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text() | st.integers(),
        lambda s: st.lists(s) | st.dictionaries(st.text(), s),
    )
)
@settings(max_examples=100, deadline=None)
def test_any_json_at_all_is_refused_and_changes_nothing(service: PhoneService, session: str, anything: Any) -> None:
    before = snapshot(service, session)
    path = f"/v1/sessions/{session}/batches"
    answer = service.client.post(
        path, content=json.dumps(anything).encode(), headers={"Content-Type": "application/json"}
    )
    assert 400 <= answer.status_code < 500
    assert snapshot(service, session) == before


@pytest.mark.parametrize("stream", ["wifi", "bluetooth"])
def test_a_hundred_thousand_readings_are_refused_by_field(service: PhoneService, session: str, stream: str) -> None:
    body = good(1)
    body[stream] = [{"t": T0 + 1000, "readings": [{"rssi": -1}] * 100_000}]
    before = snapshot(service, session)
    answer = service.send(session, body)
    assert answer.status_code == 413 and f"{stream}[0].readings" in answer.text
    assert snapshot(service, session) == before


@pytest.mark.parametrize("odd", [*NOT_PLAUSIBLE, -2, 2_412_000_000, -2_147_483_648])
def test_a_number_that_no_phone_can_mean_costs_its_reading_at_most(service: PhoneService, odd: float) -> None:
    session, body = service.open(), good(0)
    body["wifi"][0]["readings"][0] |= {"seen": odd, "frequency": odd}
    body["wifi"][1]["readings"][0]["rssi"] = odd
    body["bluetooth"][0]["readings"][0]["tx_power"] = odd
    body["bluetooth"][1]["readings"][0]["rssi"] = odd
    headers = {"Content-Type": "application/json"}
    answer = service.client.post(f"/v1/sessions/{session}/batches", content=json.dumps(body), headers=headers)
    assert answer.status_code == 200, answer.text
    assert answer.json()["dropped"] == (0 if odd == -2 else 3)


def test_after_all_that_the_session_goes_on(service: PhoneService, session: str) -> None:
    assert service.fix(session, copy.deepcopy(good(1)))["position"]["x"] == 2.0
