"""Imports go one way only, and what is below the services is pure: no web, no database, no clock, no chance."""

from __future__ import annotations

import ast
import sys
import tomllib

import pytest

from tests.architecture.source_tree import ROOT, imported, name_of, parsed, part_of, part_of_import, python_files

_NOUNS = frozenset({"errors", "estimation", "observations"})
_PARTS = _NOUNS | {"wifi", "pdr", "integrity", "floorplan"}
_OFFLINE = _PARTS | {"fusion", "survey", "settings"}

MAY_IMPORT: dict[str, frozenset[str]] = {
    "errors": frozenset(),
    "estimation": frozenset({"errors"}),
    "observations": frozenset({"errors", "estimation"}),
    "wifi": _NOUNS,
    "pdr": _NOUNS,
    "integrity": _NOUNS,
    "floorplan": _NOUNS,
    "survey": _NOUNS | {"wifi", "pdr", "floorplan"},
    "fusion": _PARTS,
    "settings": frozenset({"errors"}),
    "storage": _OFFLINE,
    "services": _OFFLINE | {"storage"},
    "api": _OFFLINE | {"storage", "services"},
    "simulation": _OFFLINE,
    "evaluation": _OFFLINE | {"simulation"},
}
"""Part of app/ -> the other parts that it may import. What is missing here (main, cli, commands) wires and sees all."""
WIRING = {"main", "cli", "commands"}
PURE = ("estimation", "observations", "wifi", "pdr", "integrity", "floorplan", "fusion", "errors")
IMPURE_MODULES = {
    "pydantic", "pydantic_settings", "fastapi", "starlette", "sqlalchemy", "alembic", "redis", "httpx", "uvicorn",
    "asyncio", "threading", "time", "datetime", "random", "secrets", "uuid", "socket", "os", "subprocess",
}  # fmt: skip


def app_files() -> list[str]:
    return [name_of(path) for path in python_files("app")]


def pure_files() -> list[str]:
    return [name_of(path) for path in python_files("app") if part_of(path) in PURE]


@pytest.mark.parametrize("name", app_files())
def test_a_file_imports_only_what_is_below_it(name: str) -> None:
    path = ROOT / name
    own = part_of(path)
    if own in WIRING or own == "__init__":
        return
    assert own in MAY_IMPORT, f"say in MAY_IMPORT what the new part {own} may import"
    parts = {part for part in map(part_of_import, imported(parsed(path))) if part is not None}
    assert parts - {own} <= MAY_IMPORT[own]


@pytest.mark.parametrize("name", pure_files())
def test_below_the_services_nothing_knows_the_web_a_store_a_clock_or_chance(name: str) -> None:
    tree = parsed(ROOT / name)
    assert {module.split(".")[0] for module in imported(tree)} & IMPURE_MODULES == set()
    for node in ast.walk(tree):
        assert not isinstance(node, ast.AsyncFunctionDef | ast.Await | ast.AsyncFor | ast.AsyncWith)
        assert not (isinstance(node, ast.Attribute) and node.attr == "random"), "numpy.random is chance"
        assert not (isinstance(node, ast.Name) and node.id in ("open", "input", "print"))


def test_the_allowed_imports_have_no_circle() -> None:
    def below(part: str, path: tuple[str, ...] = ()) -> None:
        assert part not in path, f"circle: {' -> '.join((*path, part))}"
        for other in MAY_IMPORT[part]:
            below(other, (*path, part))

    for part in MAY_IMPORT:
        below(part)


def test_only_the_wiring_imports_the_wiring() -> None:
    for path in python_files("app"):
        if part_of(path) not in WIRING:
            assert WIRING & {part_of_import(module) for module in imported(parsed(path))} == set(), name_of(path)


def test_everything_that_is_imported_is_a_declared_dependency() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    names = {"python-multipart": "python_multipart", "prometheus-client": "prometheus_client", "pillow": "PIL"}
    names |= {"pydantic-settings": "pydantic_settings"}
    words = [line.split(">")[0].split("[")[0] for line in project["dependencies"]]
    declared = {names.get(word, word) for word in words}
    comes_along = {"starlette", "typing_extensions"}  # part of the API of fastapi and pydantic
    for path in python_files("app", "migrations"):
        roots = {module.split(".")[0] for module in imported(parsed(path))}
        assert roots - set(sys.stdlib_module_names) - {"app", "migrations"} <= declared | comes_along, name_of(path)
