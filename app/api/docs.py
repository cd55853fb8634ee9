"""The API page at `/docs`: Swagger UI from an installed package, so that it works without the internet."""

from __future__ import annotations

from importlib.resources import files
from pathlib import Path

from fastapi import APIRouter
from fastapi.responses import FileResponse

from app.api.console import FILES, HEADERS
from app.errors import NotFound

ASSETS = {"swagger-ui.css": "text/css", "swagger-ui-bundle.js": "text/javascript"}
FOLDER = Path(str(files("fastapi_offline"))) / "static"
# Swagger UI's style sheet has its pictures within it
POLICY = HEADERS["Content-Security-Policy"].replace("img-src 'self' blob:", "img-src 'self' data:")

router = APIRouter(include_in_schema=False)


@router.get("/docs")
async def page() -> FileResponse:
    """The page; what it describes is `/openapi.json`."""
    return FileResponse(
        FILES["docs.html"], media_type="text/html", headers={**HEADERS, "Content-Security-Policy": POLICY}
    )


@router.get("/docs/{name}")
async def asset(name: str) -> FileResponse:
    """One of Swagger UI's files."""
    if name not in ASSETS:
        raise NotFound(f"the API page has no file {name[:64]!r}")
    return FileResponse(FOLDER / name, media_type=ASSETS[name], headers=HEADERS)
