"""Where the recorded data sets are; they are read in place and never committed."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

ROOT = Path(os.environ.get("SUREFIX_DATA", Path(__file__).parents[1].parent / "shared" / "data"))


def open_data(*parts: str) -> Path:
    """Path of a recording; skips the calling test with the reason where it is missing, fails it under CI=true."""
    path = ROOT.joinpath(*parts)
    if not path.exists():
        reason = f"recorded data {'/'.join(parts)} not found under {ROOT}; set SUREFIX_DATA to the folder that holds it"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
    return path
