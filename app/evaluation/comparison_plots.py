"""One distribution of errors a site, small enough to be kept beside the page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from app.evaluation.replay import Answer
from app.evaluation.scoring import covered_errors_m

_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "figure.dpi": 100,
}
_DASHED = ("wifi_alone", "pdr_alone")


def site_distribution(answers: Mapping[str, Sequence[Answer]], title: str, path: Path) -> None:
    """Empirical distribution of the error at covered waypoints of every row given; parts alone are dashed."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(7.2, 4.2), layout="constrained")
        axes = figure.subplots()
        longest_m = 0.0
        for index, (name, found) in enumerate(answers.items()):
            errors = np.sort(covered_errors_m(found))
            if not errors.size:
                continue
            share = np.arange(1, errors.size + 1) / errors.size
            style = "--" if name.endswith(_DASHED) else "-"
            axes.step(errors, share, where="post", color=f"C{index % 10}", lw=1.5, ls=style, label=name)
            longest_m = max(longest_m, float(np.quantile(errors, 0.95)) if style == "-" else 0.0)
        for level in (0.5, 0.95):
            axes.axhline(level, color="0.85", lw=0.8, zorder=0)
        axes.set(title=title, xlabel="horizontal error, m", ylabel="share with no more")
        axes.set(xlim=(0.0, 1.5 * max(longest_m, 1.0)), ylim=(0.0, 1.005))
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="lower right", fontsize=8)
        figure.savefig(path)
