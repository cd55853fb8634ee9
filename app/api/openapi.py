"""The OpenAPI document of the service, and the command that writes or compares the committed one.

python -m app.api.openapi openapi/openapi.json            writes it
python -m app.api.openapi --check openapi/openapi.json    ends with code 1 where the two differ
"""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from app.api.problems import MEDIA_TYPE

PROBLEM_SCHEMA = {
    "type": "object",
    "description": "RFC 9457. `type` is stable and names the kind; for bad input `field` and `pointer` say where.",
    "required": ["type", "title", "status", "detail"],
    "properties": {
        "type": {"type": "string", "examples": ["urn:surefix:problem:invalid-input"]},
        "title": {"type": "string"},
        "status": {"type": "integer"},
        "detail": {"type": "string"},
        "field": {"type": "string", "examples": ["wifi[0].t"]},
        "pointer": {"type": "string", "examples": ["#/wifi/0/t"]},
    },
}
_PROBLEM = {
    "description": "Anything else: a problem document",
    "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}},
}
_OF_FASTAPI = ("HTTPValidationError", "ValidationError")


def install_openapi(app: FastAPI) -> None:
    """Make the application describe its errors as they are: problem documents, not FastAPI's own shape."""

    def document() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _described(app)
        return app.openapi_schema

    app.openapi = document  # type: ignore[method-assign]


def _described(app: FastAPI) -> dict[str, Any]:
    document = get_openapi(title=app.title, version=app.version, description=app.description, routes=app.routes)
    for operations in document["paths"].values():
        for operation in operations.values():
            operation["responses"].pop("422", None)
            operation["responses"].setdefault("default", _PROBLEM)
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    for name in _OF_FASTAPI:
        schemas.pop(name, None)
    schemas["Problem"] = PROBLEM_SCHEMA
    return document


def rendered(app: FastAPI) -> str:
    """The document as it is committed: the same text for the same service."""
    return json.dumps(app.openapi(), indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def main(arguments: Sequence[str]) -> int:
    """Write or compare; gives the exit code."""
    check = "--check" in arguments
    paths = [Path(one) for one in arguments if one != "--check"]
    if len(paths) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    # by name: the document is of the wired service, and api may not import what wires it
    wanted = rendered(importlib.import_module("app.main").create_app())
    if not check:
        paths[0].parent.mkdir(parents=True, exist_ok=True)
        paths[0].write_text(wanted, encoding="utf-8")
        return 0
    if paths[0].is_file() and paths[0].read_text(encoding="utf-8") == wanted:
        return 0
    print(f"{paths[0]} differs from the service; `make openapi` writes it anew", file=sys.stderr)
    return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
