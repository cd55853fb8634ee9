"""The quality report of the radio map in use, opened from the console in a real browser."""

from __future__ import annotations

import base64
import io
import re
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from app.api.report_document import document
from tests.scenarios.console_service import Answer, console_over, refused, seen
from tests.scenarios.test_console_alerts import FLOOR, VENUE

DRIVER = """
const open = window.open.bind(window);
window.open = (...asked) => { window.opened = open(...asked); return window.opened; };
sessionStorage.setItem('surefix-api-key', 'a key');
setTimeout(() => document.getElementById('quality').click(), 3000);
setInterval(() => {
  const page = window.opened?.document;
  if (!page?.body) return;
  document.body.dataset.keys = window.opened.sessionStorage.length;
  document.body.dataset.text = page.body.innerText;
  document.body.dataset.image = page.querySelector('img')?.naturalWidth;
  document.body.dataset.color = getComputedStyle(page.querySelector('p') ?? page.body).color;
}, 200);
"""
QUALITY = "/v1/venues/mall/radio-maps/7/quality.html"
TASK = "/v1/tasks/t"
QUIET = "rgb(90, 104, 118)"
"""The colour of the report's own style."""


def answers(version: int | None, **others: Any) -> dict[str, Any]:
    venue = {**VENUE, "version": version}
    return {
        "/v1/venues": {"venues": [venue]},
        "/v1/venues/mall": {**venue, "floors": [FLOOR]},
        "/v1/venues/mall/floors/F1": {**FLOOR, "plan": None},
        "/v1/venues/mall/phones": {"phones": []},
        **others,
    }


def report() -> Answer:
    picture = io.BytesIO()
    Image.new("RGB", (4, 2), "red").save(picture, "PNG")
    image = f'<img src="data:image/png;base64,{base64.b64encode(picture.getvalue()).decode()}" alt="">'
    return Answer(document("mall", f"<p>how good it is</p>{image}<script>document.body.remove()</script>"), "text/html")


def told(page: str, name: str) -> str:
    found = re.search(rf'<body[^>]*data-{name}="([^"]*)"', page)
    assert found is not None
    return found[1]


def test_the_report_is_waited_for_and_shown_in_a_tab_with_its_style_and_picture_and_without_the_key(
    tmp_path: Path,
) -> None:
    waiting = Answer(b"", "text/html", 202, {"Location": TASK})
    pages, states = iter([waiting]), iter(["running", "running"])
    made = {
        QUALITY: lambda: next(pages, report()),
        TASK: lambda: {"status": next(states, "done"), "problem": None},
    }
    with console_over(answers(7, **made), DRIVER) as address:
        page = seen(address, tmp_path, 15_000)
    assert told(page, "text").strip() == "how good it is"  # no script in it runs
    assert (told(page, "image"), told(page, "color"), told(page, "keys")) == ("4", QUIET, "0")


@pytest.mark.parametrize(
    "made",
    [
        {QUALITY: refused(403, "the API key needs scope survey")},
        {
            QUALITY: Answer(b"", "text/html", 202, {"Location": TASK}),
            TASK: {"status": "failed", "problem": {"status": 503, "detail": "the API key needs scope survey"}},
        },
    ],
)
def test_where_there_is_none_to_show_the_tab_says_why(tmp_path: Path, made: dict[str, Any]) -> None:
    with console_over(answers(7, **made), DRIVER) as address:
        page = seen(address, tmp_path, 9000)
    assert told(page, "text") == "There is no report to show. The API key needs scope survey."


def test_a_venue_without_a_radio_map_offers_no_report(tmp_path: Path) -> None:
    with console_over(answers(None)) as address:
        page = seen(address, tmp_path)
    assert re.search(r'<button[^>]*id="quality"[^>]*hidden', page)
