from __future__ import annotations

import dataclasses
from typing import Any

import orjson
import pytest

from app.services.alerts import alert_of
from app.storage.session_rows import FixRow, SessionRow

SESSION = "0123456789abcdef0123456789abcdef"
BEFORE = SessionRow(SESSION, "mall", 1, "surefix", 10.0, 0.01, 0, 4, 4000, b"", None)


def fix(flag: str, reason: str = "far", position: dict[str, Any] | None = None) -> bytes:
    integrity = {"flag": flag, "excluded": [{"observation": "wifi", "reason": reason}]}
    return orjson.dumps({"session": SESSION, "t": 5000, "position": position, "integrity": integrity})


def told(before: bytes | None, after: bytes) -> dict[str, Any] | None:
    alert = alert_of(dataclasses.replace(BEFORE, newest_body=before), FixRow(5, 5000, after), 7)
    return None if alert is None else dict(orjson.loads(alert.body))


@pytest.mark.parametrize(
    ("before", "after", "kind"),
    [
        (None, "fault", "alert.raised"),
        ("nominal", "fault", "alert.raised"),
        ("fault", "coasting", "alert.cleared"),
        ("fault", "fault", None),
        ("nominal", "outlier", None),
        (None, "initialising", None),
    ],
)
def test_an_alert_is_where_the_flag_enters_fault_and_where_it_leaves(
    before: str | None, after: str, kind: str | None
) -> None:
    body = told(None if before is None else fix(before), fix(after))
    assert (None if body is None else (body["type"], body["flag"])) == (None if kind is None else (kind, after))


def test_it_says_where_and_why_but_neither_whose_session_nor_the_coordinates() -> None:
    body = told(None, fix("fault", position={"x": 81.25, "y": 93.75, "floor": "F1"}))
    assert body is not None
    assert (body["venue"], body["floor"], body["sequence"], body["t"], body["created"]) == ("mall", "F1", 5, 5000, 7)
    assert body["excluded"] == [{"observation": "wifi", "reason": "far"}]
    text = orjson.dumps(body)
    assert SESSION.encode() not in text and b"81.25" not in text and b"93.75" not in text


def test_text_that_reads_like_a_flag_is_none() -> None:
    assert told(None, fix("nominal", '{"flag":"fault"}')) is None


def test_the_same_alert_has_the_same_event_and_others_have_others() -> None:
    first, again = told(None, fix("fault")), told(fix("nominal"), fix("fault"))
    assert first is not None and again is not None and first["event"] == again["event"]
    other = alert_of(dataclasses.replace(BEFORE, session="f" * 32), FixRow(5, 5000, fix("fault")), 7)
    later = alert_of(BEFORE, FixRow(6, 6000, fix("fault")), 7)
    assert other is not None and later is not None
    assert len({first["event"], other.event, later.event}) == 3
