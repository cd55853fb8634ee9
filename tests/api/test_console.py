from __future__ import annotations

import re
from contextlib import suppress

import pytest
from fastapi import FastAPI
from fastapi.testclient import TestClient

from app.api.console import FILES, FOLDER, router
from app.errors import NotFound

app = FastAPI()
app.include_router(router)
client = TestClient(app)


def test_every_file_that_the_page_names_is_served_with_its_type() -> None:
    page = client.get("/")
    assert page.headers["content-type"].startswith("text/html")
    named = set(re.findall(r'(?:src|href)="console/([^"]+)"', page.text))
    imported = {name for path in FOLDER.glob("*.js") for name in re.findall(r'from "\./([^"]+)"', path.read_text())}
    for name in named | imported:
        asset = client.get(f"/console/{name}")
        assert asset.status_code == 200
        assert asset.headers["x-content-type-options"] == "nosniff"
        assert asset.content == FILES[name].read_bytes()


def test_the_page_may_load_nothing_from_elsewhere_and_nothing_inline() -> None:
    policy = client.get("/").headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    page = FILES["index.html"].read_text()
    assert not re.search(r"<script(?![^>]*src=)|<style|style=|\son\w+=", page)


def test_no_script_puts_data_into_markup() -> None:
    for name, path in FILES.items():
        assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\b", path.read_text()), name


@pytest.mark.parametrize("name", ["nothing.js", "..%2fmain.py", "%2e%2e%2fapi%2fconsole.py", "__init__.py"])
def test_nothing_but_the_pages_files_is_served(name: str) -> None:
    with suppress(NotFound):  # app/api/problems.py makes a 404 of it in the whole service
        assert client.get(f"/console/{name}").status_code == 404


@pytest.mark.parametrize("wanted", ["bytes=0-3", "bytes=abc", "bytes=99999999-"])
def test_a_file_is_served_whole_whatever_range_is_asked_for(wanted: str) -> None:
    answer = client.get("/", headers={"Range": wanted})
    assert (answer.status_code, answer.content) == (200, FILES["index.html"].read_bytes())


def test_who_has_a_file_already_is_not_sent_it_again() -> None:
    tag = client.get("/console/style.css").headers["etag"]
    assert client.get("/console/style.css", headers={"If-None-Match": tag}).status_code == 304
    assert client.get("/console/plan.js", headers={"If-None-Match": tag}).status_code == 200
