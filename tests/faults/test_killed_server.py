from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.faults.phone_server import PhoneServer
from tests.odometer import FAULT_BSSID

T0 = 1_573_190_000_000


@pytest.fixture
def server(tmp_path: Path) -> Iterator[PhoneServer]:
    with PhoneServer(f"sqlite:///{tmp_path / 'phones.db'}") as made:
        yield made


def batch(sequence: int) -> dict[str, Any]:
    times = [T0 + 1000 * sequence + 10 * i for i in range(20)]
    columns = {"t": times, "x": [0.0] * 20, "y": [0.0] * 20, "z": [9.8] * 20}
    bssid = f"{FAULT_BSSID:012x}" if sequence == 3 else "a80cca039dd7"
    scan = {"t": times[-1], "readings": [{"bssid": bssid, "rssi": -50}]}
    return {"sequence": sequence, "accelerometer": columns, "wifi": [scan]}


def opened(server: PhoneServer) -> str:
    return str(server.client.post("/v1/sessions", json={"venue": "mall", "method": "odometer"}).json()["session"])


def sent(server: PhoneServer, session: str, sequence: int) -> dict[str, Any]:
    answer = server.client.post(f"/v1/sessions/{session}/batches", json=batch(sequence))
    assert answer.status_code == 200, answer.text
    return {**answer.json(), "session": ""}


def test_a_server_killed_between_batches_continues_the_session_as_if_nothing_had_been(server: PhoneServer) -> None:
    session, undisturbed = opened(server), opened(server)
    expected = [sent(server, undisturbed, n) for n in range(9)]
    fixes = []
    for sequence in range(9):
        if sequence % 3 == 2:
            server.restart()
        fixes.append(sent(server, session, sequence))
    assert fixes == expected
    track = server.client.get(f"/v1/sessions/{session}/track").json()["fixes"]
    assert [{**fix, "session": ""} for fix in track] == expected


def test_a_server_killed_amid_batches_has_stored_each_one_or_not_at_all(server: PhoneServer) -> None:
    session, undisturbed = opened(server), opened(server)
    expected = [sent(server, undisturbed, n) for n in range(60)]
    killer = threading.Timer(0.05, server.kill)
    killer.start()
    answered = -1
    try:
        for sequence in range(60):
            sent(server, session, sequence)
            answered = sequence
    except httpx.TransportError:
        pass
    killer.join()
    server.restart()
    stored = server.client.get(f"/v1/sessions/{session}/fix").json()["sequence"]
    assert stored in (answered, answered + 1)
    rest = [sent(server, session, n) for n in range(answered + 1, 60)]  # the phone does not know, and repeats
    assert rest == expected[answered + 1 :]


def test_events_come_as_they_happen_and_go_on_after_the_last_that_arrived(server: PhoneServer) -> None:
    session = opened(server)
    sent(server, session, 0)
    ticket = server.client.post(f"/v1/sessions/{session}/tickets").json()["ticket"]
    path = f"/v1/sessions/{session}/events"
    with server.client.stream("GET", path, params={"ticket": ticket}, headers={"Authorization": ""}) as response:
        assert response.headers["Content-Type"].startswith("text/event-stream")
        lines = response.iter_lines()
        assert events(lines, 1) == [("fix", 0)]
        sent(server, session, 1)
        assert events(lines, 1) == [("fix", 1)]
    for sequence in (2, 3, 4):
        sent(server, session, sequence)
    with server.client.stream("GET", path, headers={"Last-Event-ID": "1"}) as response:
        got = events(response.iter_lines(), 5)
    assert got == [("fix", 2), ("alert", 3), ("fix", 3), ("alert", 4), ("fix", 4)]


def events(lines: Iterator[str], count: int) -> list[tuple[str, int]]:
    """Names and sequences of the next events of a stream."""
    got, name = [], ""
    for line in lines:
        field, _, value = line.partition(": ")
        if field == "event":
            name = value
        elif field == "data":
            got.append((name, int(json.loads(value)["sequence"])))
            if len(got) == count:
                break
    return got
