"""What the page of a quality report says where there is little to tell, or more than it shows."""

from __future__ import annotations

import re
from typing import Any

import pytest

from app.api.quality_page import page_of, waiting_page
from app.services.quality_description import MOST_NAMED
from app.services.quality_report import examined
from app.wifi.radio_map import build_radio_map
from tests.services.test_quality_report import FLOORS, survey


@pytest.fixture(scope="module")
def lone() -> dict[str, Any]:
    """The report of a survey of one fingerprint."""
    one = survey(("F1",))[:1]
    drift: dict[str, Any] = {
        "since": 0,
        "score": None,
        "squares": 0,
        "resurvey": [],
        "watched_share": 0.0,
        "access_points": [],
    }
    return {**examined(one, build_radio_map(one, 1), FLOORS).described, "created": 0, "drift": drift}


def shown(told: dict[str, Any]) -> str:
    return page_of("mall", told, b"").decode()


def figure(page: str, name: str) -> str:
    (value,) = re.findall(f"<dt>{name}</dt><dd>(.*?)</dd>", page)
    return str(value)


def section(page: str, title: str) -> str:
    (found,) = re.findall(f"<section><h2>{title}</h2>(.*?)</section>", page, re.DOTALL)
    return str(found)


def test_of_a_survey_from_which_nothing_could_be_placed_no_figure_is_made_up(lone: dict[str, Any]) -> None:
    page = shown(lone)
    assert "1 WiFi fingerprint of 1 walk." in page
    assert (figure(page, "mean error"), figure(page, "wrong floor")) == ("–", "–")
    assert figure(page, "smallest risk").startswith("none yet")
    assert '<td class="number">none yet</td>' in section(page, "Floors")


def test_the_share_on_a_wrong_floor_is_of_all_scans_that_were_tried(lone: dict[str, Any]) -> None:
    error = {**lone["error"], "scans": 10, "unplaced": 9, "wrong_floor": 1}
    assert figure(shown({**lone, "error": error}), "wrong floor") == "10.0 %"


@pytest.mark.parametrize(("count", "said"), [(8, None), (11, "3 more: see the JSON."), (MOST_NAMED, "up to 20")])
def test_a_table_that_is_cut_says_how_many_more_there_are_and_where(
    lone: dict[str, Any], count: int, said: str | None
) -> None:
    gap = {"x": 1.0, "y": 2.0, "area": 9.0, "distance": 6.0, "bounds": []}
    (floor,) = lone["floors"]
    floors = [{**floor, "coverage": {**floor["coverage"], "gaps": [gap] * count}}]
    page = shown({**lone, "floors": floors})
    gaps = section(page, "Coverage gaps")
    assert gaps.count("9 m²") == 8
    assert (said in gaps) if said else "more" not in gaps
    assert "/v1/venues/mall/radio-maps/1/quality</code>" in page


def test_the_watch_list_is_whole_in_the_json(lone: dict[str, Any]) -> None:
    watched = {"floor": "F1", "x": 1.0, "y": 2.0, "bssid": "00:00:00:00:00:01", "reason": "moved"}
    drift = {**lone["drift"], "access_points": [watched] * MOST_NAMED}
    found = section(shown({**lone, "drift": drift}), "Watched access points")
    assert found.count("moved") == 16 and f"{MOST_NAMED - 16} more: see the JSON." in found


def test_the_page_that_waits_loads_itself_again_only_where_that_can_succeed() -> None:
    assert b'http-equiv="refresh" content="5"' in waiting_page("mall", 1, 5)
    assert b"refresh" not in waiting_page("mall", 1, None)
