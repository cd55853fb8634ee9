"""Accuracy on the open recordings, all folds pooled: `python -m benchmarks.accuracy [options of surefix evaluate]`."""

from __future__ import annotations

import os
import sys
from pathlib import Path

from app.commands.evaluate import app

DATA = Path(os.environ.get("SUREFIX_DATA", Path(__file__).parents[2] / "shared" / "data"))

if __name__ == "__main__":
    out = Path("build") / "accuracy"
    app(
        [str(DATA / "mall"), "--fold", "all", "--out", str(out), *sys.argv[1:]],
        prog_name="python -m benchmarks.accuracy",
    )
