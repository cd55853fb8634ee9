"""What the documents promise to name is named in them, and what is locked is locked."""

from __future__ import annotations

import ast
import re

import pytest

from app.fusion.methods import METHODS
from app.observations import Flag
from app.settings import Settings
from tests.architecture.source_tree import FOLDERS, ROOT, name_of, parsed, python_files

DOCUMENTS = sorted(name_of(path) for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md")))
LOCKS = ("requirements/run.txt", "requirements/dev.txt")


def text(name: str) -> str:
    return (ROOT / name).read_text()


def test_every_method_has_a_page() -> None:
    pages = {path.stem for path in (ROOT / "docs" / "methods").glob("*.md")}
    assert set(METHODS) <= pages
    assert {method.method for method in METHODS.values()} == set(METHODS)


@pytest.mark.parametrize("setting", sorted(Settings.model_fields))
def test_every_setting_is_explained_to_the_operator_with_its_default(setting: str) -> None:
    row = re.search(
        rf"^\| `SUREFIX_{setting.upper()}` \| ([^|]*) \| ([^|]+) \|$", text("docs/operations.md"), re.MULTILINE
    )
    assert row is not None, f"docs/operations.md has no row for SUREFIX_{setting.upper()}"
    default = Settings.model_fields[setting].default
    written = row[1].strip().strip("`").replace(" ", "")
    assert written == ("" if default is None else str(default).replace(" ", ""))


def test_the_operator_is_told_of_no_setting_that_does_not_exist() -> None:
    named = set(re.findall(r"SUREFIX_([A-Z_]+)", text("docs/operations.md")))
    assert named - {"DATA", "KEY"} <= {setting.upper() for setting in Settings.model_fields}


@pytest.mark.parametrize("flag", list(Flag))
def test_every_flag_is_defined(flag: Flag) -> None:
    assert f"| `{flag}` |" in text("docs/conventions.md")


def test_the_readme_shows_every_folder() -> None:
    tree = text("README.md")
    folders = [path for path in (ROOT / "app").iterdir() if path.is_dir() and path.name != "__pycache__"]
    for folder in [*folders, *(ROOT / name for name in ("migrations", "openapi", "docker", "benchmarks", "docs"))]:
        assert re.search(rf"^ +{folder.name}/ ", tree, re.MULTILINE), f"README.md does not show {folder.name}/"


def made(document: str) -> set[str]:
    """What `make` is told in a document, between backticks or on an indented line."""
    told = re.findall(r"`make ([^`]*)`|^ {4}make ([^#\n]*)", text(document), re.MULTILINE)
    return {word for one in told for word in "".join(one).split() if re.fullmatch(r"[a-z-]+", word)}


def test_every_make_command_of_the_documents_is_one_of_the_makefile() -> None:
    targets = set(re.findall(r"^([a-z-]+):", text("Makefile"), re.MULTILINE))
    assert {document: made(document) - targets for document in DOCUMENTS if made(document) - targets} == {}
    assert {"run", "check", "evaluate", "ageing"} <= made("README.md")
    assert {"check", "openapi", "lock"} <= made("CONTRIBUTING.md")


def paths_in(words: str) -> set[str]:
    """Files and folders of the project that a text names; of `app/fusion/<id>.py` the folder."""
    return set(re.findall(rf"(?<![\w./-])(?:{'|'.join((*FOLDERS, 'docs'))})/(?:[\w./*-]*\w)?", words))


def missing(words: str) -> set[str]:
    return {path for path in paths_in(words) if not any(ROOT.glob(path))}


@pytest.mark.parametrize("document", DOCUMENTS)
def test_every_path_that_a_document_names_exists(document: str) -> None:
    assert missing(text(document)) == set()


def test_every_path_that_a_docstring_names_exists() -> None:
    docstrings = {
        name_of(path): "\n".join(
            node.value.value
            for node in ast.walk(parsed(path))
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
        )
        for path in python_files()
    }
    assert len(set().union(*map(paths_in, docstrings.values()))) > 5
    assert {name: missing(words) for name, words in docstrings.items() if missing(words)} == {}


@pytest.mark.parametrize("lock", LOCKS)
def test_every_locked_package_has_an_exact_version_and_hashes_and_no_address(lock: str) -> None:
    content = text(lock)
    assert "://" not in content
    entries = re.split(r"\n(?=[a-z])", content[content.index("\n\n") :].strip())
    assert len(entries) > 40
    for entry in entries:
        assert re.match(r"[a-z0-9][a-z0-9._-]*==[0-9][\w.+!-]* *[;\\]", entry), entry[:80]
        assert "--hash=sha256:" in entry
    assert not re.search(r"^\s*--(?!hash)", content, re.MULTILINE)


def test_what_runs_is_locked_to_the_same_version_wherever_it_is_tested() -> None:
    run, dev = (set(re.findall(r"^[a-z0-9][^\\\n]*==[^\\\n]*", text(lock), re.MULTILINE)) for lock in LOCKS)
    assert run <= dev
