"""The project's own Python files as the architecture tests read them: parsed, never imported."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
FOLDERS = ("app", "migrations", "tests", "benchmarks")


def python_files(*folders: str) -> list[Path]:
    """Paths under these folders of the root (default: all of the project's), sorted."""
    return sorted(path for folder in folders or FOLDERS for path in (ROOT / folder).rglob("*.py"))


def name_of(path: Path) -> str:
    """The path as it is written in a message: relative to the root."""
    return path.relative_to(ROOT).as_posix()


@cache
def parsed(path: Path) -> ast.Module:
    """The file's syntax tree."""
    return ast.parse(path.read_text(), name_of(path))


def imported(tree: ast.Module) -> Iterator[str]:
    """Dotted names of every module that is imported anywhere in the file, within functions too.

    `from app import settings` names `app.settings`; `from app.settings import Settings` names `app.settings.Settings`.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module is not None:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def part_of(path: Path) -> str:
    """The part of app/ that a file belongs to: `wifi` for app/wifi/match.py, `errors` for app/errors.py."""
    return path.relative_to(ROOT / "app").parts[0].removesuffix(".py")


def part_of_import(module: str) -> str | None:
    """The part of app/ that an imported module belongs to, None where it is not ours."""
    words = module.split(".")
    return words[1] if words[0] == "app" and len(words) > 1 else None
