"""The console in a real browser, over a service that plays one phone's alert from beginning to end."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.scenarios.console_service import console_over, seen

FLAGS = ("nominal", "fault", "fault", "nominal", "fault")
"""Poll by poll; the last stays."""
VENUE = {"venue": "mall", "name": "Mall", "created": 0, "version": 1}
FLOOR = {"floor": "F1", "name": "F1", "level": 0, "width": 40.0, "height": 20.0, "georeference": None}
MARKUP = "<b>moved</b>"


def phone(name: str, flag: str) -> dict[str, Any]:
    excluded = [{"bssid": "a8:0c:ca:03:9d:d7", "reason": MARKUP}, {"observation": "wifi", "reason": "far"}]
    integrity = {"flag": flag, "usable": flag != "fault", "protection_level": 6.0, "alert_limit": 10.0, "risk": 0.01}
    integrity["excluded"] = excluded if flag == "fault" else []
    position = {"x": 5.0, "y": 5.0, "floor": "F1", "latitude": None, "longitude": None}
    fix = {"position": position, "accuracy": 2.0, "heading": 1.0, "integrity": integrity}
    return {"phone": name, "age": 0.5, "fix": fix}


@pytest.fixture
def address() -> Iterator[str]:
    polls = iter(FLAGS)
    answers: dict[str, Any] = {
        "/v1/venues": {"venues": [VENUE]},
        "/v1/venues/mall": {**VENUE, "floors": [FLOOR]},
        "/v1/venues/mall/floors/F1": {**FLOOR, "plan": None},
        "/v1/venues/mall/phones": lambda: {
            "phones": [phone("ab12cd", next(polls, FLAGS[-1])), phone("ef34ab", "nominal")]
        },
    }
    with console_over(answers) as served:
        yield served


def test_alerts_are_told_as_they_are_raised_and_cleared_newest_first(address: str, tmp_path: Path) -> None:
    page = seen(f"{address}/", tmp_path, 30_000)
    found = re.search(r'<ol[^>]*id="alert-list"[^>]*>(.*?)</ol>', page, re.DOTALL)
    assert found is not None
    lines = re.findall(r"<li(.*?)</li>", found[1], re.DOTALL)
    assert [re.findall(r'data-alert="(\w+)"', line) for line in lines] == [["raised"], ["cleared"], ["raised"]]
    assert all("ab12cd" in line and "ef34ab" not in line for line in lines)
    assert "on F1: a8:0c:ca:03:9d:d7" in lines[0] and "and 1 more" in lines[0]
    assert "&lt;b&gt;moved" in lines[0] and MARKUP not in lines[0]
    assert re.search(r"after \d+ s", lines[1])
    assert re.search(r'<p[^>]*id="no-alerts"[^>]*hidden', page)
