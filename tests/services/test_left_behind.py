from __future__ import annotations

import asyncio
import os
import tempfile
import time
from pathlib import Path

import pytest

from app.services.left_behind import ABANDONED_S, remove_left_behind


def test_only_folders_of_requests_that_nobody_has_touched_for_a_day_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    long_ago_s = time.time() - ABANDONED_S - 60.0
    for name in ("surefix-upload-old", "surefix-survey-new", "surefix-metrics-old", "of-others"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file").write_text("x")
        if not name.endswith("new"):
            os.utime(tmp_path / name, (long_ago_s, long_ago_s))
    asyncio.run(remove_left_behind())
    assert {one.name for one in tmp_path.iterdir()} == {"surefix-survey-new", "surefix-metrics-old", "of-others"}
