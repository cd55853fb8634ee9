"""The web page at `/` and its files: nothing from elsewhere, nothing inline, no key needed."""

from __future__ import annotations

import zlib
from collections.abc import Mapping
from pathlib import Path

from fastapi import APIRouter, Request, Response

from app.api.report_document import STYLE_SOURCE
from app.errors import NotFound

FOLDER = Path(__file__).parents[1] / "console"
MEDIA_TYPES = {".html": "text/html", ".css": "text/css", ".js": "text/javascript", ".svg": "image/svg+xml"}
FILES = {path.name: path for path in sorted(FOLDER.iterdir()) if path.suffix in MEDIA_TYPES}
HEADERS = {
    "Content-Security-Policy": (
        # also for the quality report's page, which keeps the policy of the console that opens it in a tab, and for
        # Swagger UI's style sheet, which has its pictures within it
        f"default-src 'none'; script-src 'self'; style-src 'self' {STYLE_SOURCE}; img-src 'self' data: blob:; "
        "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",  # asked again each time, answered 304 while unchanged
}

router = APIRouter(include_in_schema=False)


def served(request: Request, path: Path, media_type: str, headers: Mapping[str, str] = HEADERS) -> Response:
    """A file, whole: ranges of it are not served, which every client must expect; 304 to who has it already."""
    content = path.read_bytes()
    tag = f'"{zlib.crc32(content):08x}-{len(content):x}"'
    headers = {**headers, "ETag": tag}
    if request.headers.get("if-none-match") == tag:
        return Response(status_code=304, headers=headers)
    return Response(content, media_type=media_type, headers=headers)


@router.head("/")
@router.get("/")
async def page(request: Request) -> Response:
    """The console."""
    return await asset(request, "index.html")


@router.get("/console/{name}")
async def asset(request: Request, name: str) -> Response:
    """One of the page's files."""
    if name not in FILES:
        raise NotFound(f"the console has no file {name!r}")
    return served(request, FILES[name], MEDIA_TYPES[FILES[name].suffix])
