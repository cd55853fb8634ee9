"""What the console draws in a real browser: plans and images, names over rooms, phones in their order."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from tests.scenarios.console_service import Answer, console_over, refused, seen
from tests.scenarios.test_console_alerts import FLOOR, VENUE, phone

ROOM_DEGREES = 0.0001
PLACE = {"latitude": 30.0, "longitude": 120.0, "rotation": 0.0}
BOXES = (
    "const box = (id) => { const { top, right, bottom, left } = document.getElementById(id).getBoundingClientRect();"
    " return [top, right, bottom, left].map(Math.round).join(); };"
    "setInterval(() => { for (const id of ['map', 'notice'])"
    " document.body.setAttribute(`data-${id}`, box(id)); }, 100);"
)


def feature(name: str, size: float) -> dict[str, Any]:
    west, south, east, north = 120.0, 30.0, 120.0 + size * ROOM_DEGREES, 30.0 + size * ROOM_DEGREES
    ring = [[west, south], [east, south], [east, north], [west, north], [west, south]]
    geometry = {"type": "Polygon", "coordinates": [ring]}
    return {"type": "Feature", "properties": {"display": name}, "geometry": geometry}


PLAN = {"type": "FeatureCollection", "features": [feature("", 3), feature("inner", 1), feature("outer", 2)]}


def answers(place: dict[str, Any] | None, phones: Any) -> dict[str, Any]:
    picture = io.BytesIO()
    Image.new("RGB", (4, 2), "red").save(picture, "PNG")
    return {
        "/v1/venues": {"venues": [VENUE]},
        "/v1/venues/mall": {**VENUE, "floors": [FLOOR]},
        "/v1/venues/mall/floors/F1": {**FLOOR, "georeference": place, "plan": PLAN},
        "/v1/venues/mall/floors/F1/image": Answer(picture.getvalue(), "image/png"),
        "/v1/venues/mall/phones": phones,
    }


def box(page: str, name: str) -> tuple[int, int, int, int]:
    """Top, right, bottom and left of an element."""
    found = re.search(rf'data-{name}="(\d+),(\d+),(\d+),(\d+)"', page)
    assert found is not None
    top, right, bottom, left = map(int, found.groups())
    return top, right, bottom, left


def test_a_plan_that_cannot_be_placed_gives_way_to_the_image(tmp_path: Path) -> None:
    with console_over(answers(None, {"phones": []})) as address:
        page = seen(address, tmp_path)
    assert re.search(r'<g id="plan"><image href="blob:', page)


def test_names_are_over_all_rooms_of_a_placed_plan_and_no_image_is_drawn(tmp_path: Path) -> None:
    with console_over(answers(PLACE, {"phones": []})) as address:
        page = seen(address, tmp_path)
    plan = re.search(r'<g id="plan">(.*?)</g>', page, re.DOTALL)
    assert plan is not None and "<image" not in plan[1]
    kinds = re.findall(r"<(path|text)", plan[1])
    assert kinds.count("text") == 2 and kinds == sorted(kinds)


def test_phones_are_listed_in_the_order_of_the_answer_and_newcomers_take_no_focus_away(tmp_path: Path) -> None:
    last = "aa", "bb", "cc", "dd"
    polls = iter([["bb", "cc"]] * 3)
    focus = (
        "setTimeout(() => { document.querySelector('#rows button').focus(); }, 1500);"
        "setInterval(() => { document.body.dataset.focus = document.activeElement.textContent; }, 100);"
    )

    def listed() -> dict[str, Any]:
        return {"phones": [phone(name, "nominal") for name in next(polls, last)]}

    with console_over(answers(PLACE, listed), focus) as address:
        page = seen(address, tmp_path, 9000)
    assert 'data-focus="bb"' in page
    rows = re.findall(r'<tr data-flag="nominal"><th scope="row"><button type="button">(\w+)</button>', page)
    assert rows == list(last)


def test_the_legend_shows_a_phone_with_its_heading(tmp_path: Path) -> None:
    with console_over(answers(PLACE, {"phones": []})) as address:
        page = seen(address, tmp_path)
    assert re.search(
        r'<svg[^>]*><line class="nose"[^>]*></line><circle class="core"[^>]*></circle></svg>the phone', page
    )


@pytest.mark.parametrize("phones", [{"phones": []}, refused(503, "the database cannot be reached")])
def test_what_is_said_about_a_floor_hides_nothing_of_it(tmp_path: Path, phones: Any) -> None:
    polls = iter([{"phones": [phone("aa", "nominal")]}])
    with console_over(answers(PLACE, lambda: next(polls, phones)), BOXES) as address:
        page = seen(address, tmp_path)
    assert re.search(r'<div class="notice strip" id="notice">', page)
    (top, _, bottom, _), (map_top, *_) = box(page, "notice"), box(page, "map")
    assert top < bottom <= map_top


@pytest.mark.parametrize("count", [3, 60])
def test_in_a_low_window_the_list_keeps_some_rows_and_the_page_itself_does_not_scroll(
    tmp_path: Path, count: int
) -> None:
    listed = {"phones": [phone(f"{at:02}", "nominal") for at in range(count)]}
    tell = (
        "setInterval(() => { const page = document.documentElement, list = document.querySelector('.scroll');"
        " document.body.dataset.low = `${page.scrollHeight - innerHeight},${list.clientHeight}`; }, 100);"
    )
    with console_over(answers(PLACE, listed), tell) as address:
        page = seen(address, tmp_path, size=(1366, 650))
    found = re.search(r'data-low="(-?\d+),(\d+)"', page)
    assert found is not None and int(found[1]) <= 0 and int(found[2]) > 130


def test_the_servers_words_about_a_key_are_a_sentence_of_their_own(tmp_path: Path) -> None:
    told = {"/v1/venues": refused(401, "the API key is unknown or revoked")}
    with console_over(told, "sessionStorage.setItem('surefix-api-key', 'wrong');") as address:
        page = seen(address, tmp_path)
    assert "The API key is unknown or revoked. Create a key that may read every phone of a venue:" in page
