"""A newcomer finds the place of a thing from its name, and a file is short enough to be read."""

from __future__ import annotations

import ast
import re

import pytest

from tests.architecture.source_tree import FOLDERS, ROOT, name_of, parsed, part_of, python_files

SAYS_NOTHING = {"util", "utils", "helper", "helpers", "common", "base", "manager", "misc", "core", "shared", "lib"}
LINES_AT_MOST = {"app": 250, "migrations": 250, "tests": 350, "benchmarks": 250}
SI_INSIDE = ("observations", "estimation", "wifi", "pdr", "integrity", "fusion")
NOT_SI = re.compile(r"_(ms|us|ns|deg|degrees|km|cm|mm|feet|ft|kmh|mw)$")
OUTSIDE_APP = {"architecture", "scenarios", "faults"}


def names(*folders: str) -> list[str]:
    return [name_of(path) for path in python_files(*folders)]


@pytest.mark.parametrize("name", names())
def test_no_file_or_folder_has_a_name_that_says_nothing(name: str) -> None:
    words = set(re.split(r"[/_.]", name))
    assert words & SAYS_NOTHING == set()
    assert re.fullmatch(r"[a-z0-9_/]+\.py", name)


@pytest.mark.parametrize("folder", FOLDERS)
def test_files_are_short_enough_to_be_read(folder: str) -> None:
    lengths = {name: len((ROOT / name).read_text().splitlines()) for name in names(folder)}
    assert {name: n for name, n in lengths.items() if n > LINES_AT_MOST[folder]} == {}


@pytest.mark.parametrize("name", names("app"))
def test_every_file_and_every_public_function_and_class_says_what_it_is(name: str) -> None:
    tree = parsed(ROOT / name)
    assert ast.get_docstring(tree)
    named = [node for node in tree.body if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)]
    assert [node.name for node in named if node.name[0] != "_" and not ast.get_docstring(node)] == []


@pytest.mark.parametrize("name", names("app"))
def test_names_inside_are_in_si_units_and_radians(name: str) -> None:
    if part_of(ROOT / name) not in SI_INSIDE:
        return
    tree = parsed(ROOT / name)
    used = {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    used |= {node.id.lower() for node in ast.walk(tree) if isinstance(node, ast.Name)}
    assert {one for one in used if NOT_SI.search(one)} == set()


def test_tests_mirror_the_application() -> None:
    parts = {path.name for path in (ROOT / "app").iterdir() if path.is_dir() and list(path.glob("*.py"))}
    mirrored = {path.name for path in (ROOT / "tests").iterdir() if path.is_dir() and list(path.glob("*.py"))}
    assert mirrored - OUTSIDE_APP <= parts
    assert parts <= mirrored
