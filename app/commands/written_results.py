"""What a measuring command leaves: its figures as JSON and as tables, in files and on standard output."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

WIDTH = 240
"""Columns of a table where no terminal says otherwise."""


def write_results(
    out: Path, name: str, document: Mapping[str, Any], show: Callable[[Console], None], as_json: bool
) -> None:
    """Write OUT/name.json and OUT/name.txt, and print one of the two.

    Parameters
    ----------
    show : prints the tables.  as_json : print the document instead of them.
    """
    (out / f"{name}.json").write_text(json.dumps(document, indent=1) + "\n")
    with (out / f"{name}.txt").open("w") as file:
        show(Console(width=WIDTH, file=file))
    if as_json:
        print(json.dumps(document, indent=1))
    else:
        show(Console(width=None if sys.stdout.isatty() else WIDTH))
