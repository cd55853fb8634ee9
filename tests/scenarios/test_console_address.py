"""The console's address in a real browser: its fragment names the venue and the floor that are shown."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from tests.scenarios.console_service import console_over, seen
from tests.scenarios.test_console_alerts import phone

TELL = "setInterval(() => { document.body.dataset.hash = location.hash; }, 100);"


def floors(*names: str) -> list[dict[str, Any]]:
    shape = {"width": 40.0, "height": 20.0, "georeference": None}
    return [{"floor": name, "name": name, "level": at, **shape} for at, name in enumerate(names)]


VENUES = {"mall": floors("F1", "F2"), "clinic": floors("C1")}


def answers() -> dict[str, Any]:
    told: dict[str, Any] = {}
    for venue, its_floors in VENUES.items():
        described = {"venue": venue, "name": venue, "created": 0, "version": None}
        told.setdefault("/v1/venues", {"venues": []})["venues"].append(described)
        told[f"/v1/venues/{venue}"] = {**described, "floors": its_floors}
        told[f"/v1/venues/{venue}/phones"] = {"phones": [phone(f"of-{venue}", "nominal")]}
        for floor in its_floors:
            told[f"/v1/venues/{venue}/floors/{floor['floor']}"] = {**floor, "plan": None}
    return told


def shown(page: str) -> tuple[str | None, str | None]:
    """The address's fragment, and the floor that is shown."""
    fragment = re.search(r'<body data-hash="([^"]*)"', page)
    selected = re.search(r'<button[^>]*data-floor="(\w+)"[^>]*aria-selected="true"', page)
    return fragment and fragment[1], selected and selected[1]


@pytest.mark.parametrize(
    ("fragment", "expected"),
    [
        ("#mall/F2", ("#mall/F2", "F2")),
        ("#mall", ("#mall/F1", "F1")),
        ("#mall/F9", ("#mall/F1", "F1")),
        ("#%", ("#clinic/C1", "C1")),
        ("#mall/%E0%A4%A", ("#clinic/C1", "C1")),
    ],
)
def test_the_page_shows_what_its_address_names_and_a_malformed_one_names_nothing(
    tmp_path: Path, fragment: str, expected: tuple[str, str]
) -> None:
    with console_over(answers(), TELL) as address:
        page = seen(f"{address}/{fragment}", tmp_path)
    assert shown(page) == expected
    assert re.search(r'id="link"[^>]*data-state="live"', page)


@pytest.mark.parametrize("name", ["mall/F2", "clinic/C1", "mall/F1"])
def test_an_open_page_follows_its_address(tmp_path: Path, name: str) -> None:
    steps = f"{TELL} setTimeout(() => {{ location.hash = '{name}'; }}, 3000);"
    with console_over(answers(), steps) as address:
        page = seen(f"{address}/#mall/F1", tmp_path, 9000)
    assert shown(page) == (f"#{name}", name.split("/")[1])
    assert f"of-{name.split('/')[0]}</button>" in page


def test_another_venue_is_shown_once_it_is_chosen_and_the_address_says_so(tmp_path: Path) -> None:
    choose = (
        "const list = document.getElementById('venue'); list.value = 'clinic'; list.dispatchEvent(new Event('change'))"
    )
    with console_over(answers(), f"{TELL} setTimeout(() => {{ {choose} }}, 3000);") as address:
        page = seen(f"{address}/#mall/F1", tmp_path, 9000)
    assert shown(page) == ("#clinic/C1", "C1")
    assert "of-clinic</button>" in page and "of-mall</button>" not in page


@pytest.mark.parametrize("steps", ["", "setTimeout(() => { location.hash = 'nowhere/F1'; }, 3000);"])
def test_of_a_venue_that_is_unknown_the_page_says_so_and_shows_no_other(tmp_path: Path, steps: str) -> None:
    with console_over(answers(), TELL + steps) as address:
        page = seen(f"{address}/#{'mall/F1' if steps else 'nowhere/F1'}", tmp_path, 9000)
    assert shown(page) == ("#nowhere/F1", None)
    assert "There is no venue “nowhere”" in page
    assert "of-mall</button>" not in page and "of-clinic</button>" not in page


def test_the_link_to_the_list_leaves_the_address_as_it_is(tmp_path: Path) -> None:
    skip = "setTimeout(() => { document.querySelector('.skip').click(); }, 3000);"
    focus = "setInterval(() => { document.body.title = document.activeElement.id; }, 100);"
    with console_over(answers(), TELL + focus + skip) as address:
        page = seen(f"{address}/#mall/F2", tmp_path, 9000)
    assert shown(page) == ("#mall/F2", "F2")
    assert 'title="phones"' in page
