from __future__ import annotations

from pathlib import Path

import pytest

from app.storage.migration import newest_revision
from tests.commands.surefix_process import surefix


def test_migrating_makes_the_database_in_the_working_directory_and_may_be_repeated(tmp_path: Path) -> None:
    for _ in range(2):
        done = surefix("migrate", folder=tmp_path)
        assert (done.returncode, done.stdout) == (0, f"the database is at revision {newest_revision()}\n")
    assert (tmp_path / "surefix.db").exists()


@pytest.mark.parametrize("url", ["sqlite:////none/of/this.db", "mysql://x", "postgresql://nobody@127.0.0.1:1/none"])
def test_a_database_that_cannot_be_made_is_told_in_a_line(tmp_path: Path, url: str) -> None:
    done = surefix("migrate", "--database", url, folder=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("surefix: ") and "Traceback" not in done.stderr
