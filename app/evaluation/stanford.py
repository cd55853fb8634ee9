"""The Stanford diagram: how often which error stood beside which protection level."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from app.evaluation.integrity import ALERT_LIMITS_M
from app.evaluation.replay import Answer
from app.observations import Flag

_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "figure.dpi": 130,
}
_BINS = 60
_WIDEST_M = 30.0
_REGIONS = {
    "nominal": "#e5f5e0",
    "misleading": "#fee0b6",
    "hazardous": "#fbb4ae",
    "unavailable": "#f0f0f0",
    "unavailable,\nmisleading": "#ddd8e6",
}


def stanford_shares(answers: Sequence[Answer], limit_m: float) -> dict[str, float]:
    """Share of each region among answers with position and level and without fault; a wrong floor errs without end.

    hazardous : the error is beyond the alert limit and the level within it.  misleading : the error is beyond the
    level, both within the limit.  nominal : in order.  unavailable : the level is beyond the limit.
    """
    error, level = _pairs(answers)
    masks = _masks(error, level, limit_m)
    return {name: float(mask.mean()) if len(error) else 0.0 for name, mask in masks.items()}


def stanford(answers: Sequence[Answer], limit_m: float, title: str, path: Path) -> None:
    """Draw the diagram; the regions are those of limit_m, the other usual limits are thin lines.

    Answers in fault make no claim and are left out. What is beyond the frame is drawn in its last bins.
    """
    error, level = _pairs(answers)
    top = max(_WIDEST_M, 2.2 * limit_m)
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(7.4, 6.2), layout="constrained")
        axes = figure.subplots()
        _regions(axes, stanford_shares(answers, limit_m), limit_m, top)
        if len(error):
            edges = np.linspace(0.0, top, _BINS + 1)
            counts, _, _ = np.histogram2d(np.minimum(error, top), np.minimum(level, top), bins=[edges, edges])
            mesh = axes.pcolormesh(
                edges, edges, np.where(counts.T > 0.0, counts.T, np.nan), norm="log", cmap="viridis_r"
            )
            figure.colorbar(mesh, ax=axes, label="answers", shrink=0.8)
        fault = sum(a.flag is Flag.FAULT for a in answers)
        axes.set(xlim=(0.0, top), ylim=(0.0, top), aspect="equal")
        axes.set(xlabel="horizontal error, m (wrong floor: at the right edge)", ylabel="protection level, m")
        axes.set_title(f"{title}\n{len(error)} answers with a level; {fault} in fault, not drawn")
        figure.savefig(path)


def _pairs(answers: Sequence[Answer]) -> Any:
    """Errors and levels, each (n,), of what makes a claim."""
    pairs = [
        (a.error_m if a.floor_right else np.inf, a.protection_level_m)
        for a in answers
        if a.error_m is not None and a.protection_level_m is not None and a.flag is not Flag.FAULT
    ]
    return np.array(pairs, dtype=np.float64).reshape(-1, 2).T


def _masks(error: Any, level: Any, limit_m: float) -> dict[str, Any]:
    told = level <= limit_m
    return {
        "nominal": told & (error <= level),
        "misleading": told & (error > level) & (error <= limit_m),
        "hazardous": told & (error > limit_m),
        "unavailable": ~told & (error <= level),
        "unavailable,\nmisleading": ~told & (error > level),
    }


def _regions(axes: Axes, shares: dict[str, float], limit_m: float, top: float) -> None:
    corners = {
        "nominal": [(0, 0), (limit_m, limit_m), (0, limit_m)],
        "misleading": [(0, 0), (limit_m, 0), (limit_m, limit_m)],
        "hazardous": [(limit_m, 0), (top, 0), (top, limit_m), (limit_m, limit_m)],
        "unavailable": [(0, limit_m), (limit_m, limit_m), (top, top), (0, top)],
        "unavailable,\nmisleading": [(limit_m, limit_m), (top, limit_m), (top, top)],
    }
    places = {
        "nominal": (0.26 * limit_m, 0.56 * limit_m),
        "misleading": (0.68 * limit_m, 0.22 * limit_m),
        "hazardous": ((limit_m + top) / 2, limit_m / 2),
        "unavailable": (0.32 * top, 0.92 * top),
        "unavailable,\nmisleading": (limit_m + 0.74 * (top - limit_m), limit_m + 0.3 * (top - limit_m)),
    }
    for name, outline in corners.items():
        axes.add_patch(Polygon(outline, facecolor=_REGIONS[name], edgecolor="none", zorder=0))
        label = axes.text(*places[name], f"{name}\n{100.0 * shares[name]:.2f} %", ha="center", va="center", zorder=4)
        label.set_bbox({"facecolor": "w", "alpha": 0.75, "edgecolor": "none", "pad": 1.5})
    axes.plot((0, top), (0, top), color="k", lw=0.9, zorder=3)
    for line_m in sorted({limit_m, *ALERT_LIMITS_M}):
        style: dict[str, Any] = {"color": "#c51b1b", "lw": 1.4 if line_m == limit_m else 0.6, "ls": "--", "zorder": 3}
        axes.axhline(line_m, **style)
        axes.axvline(line_m, **style)
        axes.text(0.995 * top, line_m, f"{line_m:g} m", color="#c51b1b", ha="right", va="bottom", fontsize=7, zorder=3)
