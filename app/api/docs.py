"""The API page at `/docs`: Swagger UI from an installed package, so that it works without the internet."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from fastapi import APIRouter, Request, Response

from app.api.console import FILES, served
from app.errors import NotFound

ASSETS = {"swagger-ui.css": "text/css", "swagger-ui-bundle.js": "text/javascript"}
FOLDER = Path(str(files("fastapi_offline"))) / "static"

router = APIRouter(include_in_schema=False)


@router.get("/docs")
async def page(request: Request) -> Response:
    """The page; what it describes is `/openapi.json`."""
    return served(request, FILES["docs.html"], "text/html")


@router.get("/docs/{name}")
async def asset(request: Request, name: str) -> Response:
    """One of Swagger UI's files."""
    if name not in ASSETS:
        raise NotFound(f"the API page has no file {name[:64]!r}")
    return served(request, FOLDER / name, ASSETS[name])
