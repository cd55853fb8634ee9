"""A batch of many thousand readings: while it is read and worked on, other phones are answered."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from app.api.batch_body import parse_batch
from app.fusion.interface import Method
from app.services.tracking import LONG_BATCH
from tests.api.phone_service import PhoneService, phone_service
from tests.odometer import ODOMETER

T0 = 1_573_190_000_000
PATIENCE_S = 10.0


@pytest.fixture
def service(tmp_path: Path) -> Iterator[PhoneService]:
    with phone_service(f"sqlite:///{tmp_path / 'phones.db'}") as made:
        yield made


class Halt:
    """A function that waits, when it is called, until it is told to go on."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function
        self.reached, self.go_on = threading.Event(), threading.Event()

    def __call__(self, *arguments: Any) -> Any:
        self.reached.set()
        if not self.go_on.wait(PATIENCE_S):
            raise TimeoutError("nobody else was answered meanwhile")
        return self._function(*arguments)


def answered_meanwhile(service: PhoneService, body: dict[str, Any], halt: Halt) -> bool:
    """Whether another session is answered while a batch waits at the halt, and the batch in the end."""
    session, other = service.open(), service.open()
    with ThreadPoolExecutor(1) as pool:
        sent = pool.submit(service.send, session, body)
        reached = halt.reached.wait(PATIENCE_S)
        answer = service.client.get(f"/v1/sessions/{other}/fix")
        halt.go_on.set()
        return reached and answer.status_code == 200 and sent.result().status_code == 200


def wifi(scans: int, readings: int) -> dict[str, Any]:
    heard = [{"bssid": f"02000000{n:04x}", "rssi": -50} for n in range(readings)]
    return {"sequence": 0, "wifi": [{"t": T0 + 100 * n, "readings": heard} for n in range(scans)]}


def magnetometer(samples: int) -> dict[str, Any]:
    zeros = [0] * samples
    return {"sequence": 0, "magnetometer": {"t": [T0 + n for n in range(samples)], "x": zeros, "y": zeros, "z": zeros}}


def test_others_are_answered_while_a_long_body_is_read(service: PhoneService, monkeypatch: pytest.MonkeyPatch) -> None:
    halt = Halt(parse_batch)
    monkeypatch.setattr("app.api.sessions.parse_batch", halt)
    assert answered_meanwhile(service, wifi(3, 2000), halt)


@pytest.mark.parametrize("body", [wifi(3, 2000), magnetometer(LONG_BATCH)], ids=["wifi", "magnetometer"])
def test_others_are_answered_while_a_method_works_on_many_readings(
    service: PhoneService, monkeypatch: pytest.MonkeyPatch, body: dict[str, Any]
) -> None:
    halt = Halt(ODOMETER.advance)
    monkeypatch.setattr(service.wired.tracking, "_methods", {"odometer": Method("odometer", ODOMETER.start, halt)})
    assert answered_meanwhile(service, body, halt)
