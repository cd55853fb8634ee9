from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from app.api.console import FILES
from app.api.docs import ASSETS
from tests.api.whole_service import whole_service


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[TestClient]:
    with whole_service(tmp_path_factory.mktemp("docs")) as made:
        yield made


def test_everything_that_the_page_names_is_served_from_here(client: TestClient) -> None:
    page = client.get("/docs")
    assert page.headers["content-type"].startswith("text/html")
    named = re.findall(r'(?:src|href)="([^"]+)"', page.text)
    assert {f"docs/{name}" for name in ASSETS} <= set(named)
    for name in named:
        assert "//" not in name
        assert client.get(f"/{name}").status_code == 200, name
    description = re.search(r'url: "([^"]+)"', FILES["docs.js"].read_text())
    assert description is not None and client.get(f"/{description[1]}").json()["info"]["title"] == "Surefix"


def test_the_page_may_load_nothing_from_elsewhere_and_nothing_inline(client: TestClient) -> None:
    page = client.get("/docs")
    policy = page.headers["content-security-policy"]
    assert "default-src 'none'" in policy and "script-src 'self'" in policy and "img-src 'self' data:" in policy
    assert "unsafe" not in policy and "http" not in policy
    assert not re.search(r"<script(?![^>]*src=)|<style|style=|\son\w+=", page.text)


def test_the_files_are_those_of_swagger_ui_5_which_reads_openapi_3_1(client: TestClient) -> None:
    assert client.get("/openapi.json").json()["openapi"].startswith("3.1")
    assert b"SwaggerUIBundle" in client.get("/docs/swagger-ui-bundle.js").content[:500]
    assert ".swagger-ui" in client.get("/docs/swagger-ui.css").text


@pytest.mark.parametrize("name", ["favicon.png", "redoc.standalone.js", "..%2fcore.py", "%2e%2e%2f__init__.py"])
def test_nothing_else_of_the_package_is_served(client: TestClient, name: str) -> None:
    assert client.get(f"/docs/{name}").status_code == 404


def test_the_installed_package_has_the_pages_own_files() -> None:
    assert {"docs.html", "docs.js"} <= set(FILES)
    assert all(isinstance(path, Path) and path.is_file() for path in FILES.values())
