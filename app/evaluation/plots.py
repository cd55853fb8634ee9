"""Plots of an evaluation, one PNG each: error distribution, tracks over the plan, error and level over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from app.evaluation.recordings import FloorFolder
from app.evaluation.replay import Answer, WalkKey
from app.evaluation.scoring import covered_errors_m, errors_m, quantile
from app.observations import Flag

FLAG_COLOURS = {
    Flag.INITIALISING: "#9e9e9e",
    Flag.NOMINAL: "#1b7837",
    Flag.CORRECTED: "#2166ac",
    Flag.OUTLIER: "#e08214",
    Flag.FAULT: "#c51b1b",
    Flag.COASTING: "#8073ac",
}
_SHOWN_QUANTILES = {"among the best": 0.05, "median": 0.5, "among the worst": 0.9, "worst": 1.0}
_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "figure.titlesize": 11,
    "legend.frameon": False,
    "figure.dpi": 130,
}
Walk = list[Answer]


def shown_walks(answers: Sequence[Answer]) -> dict[str, Walk]:
    """Four walks that stand for all: by mean error among the best, the median, among the worst and the worst."""
    walks: dict[WalkKey, Walk] = {}
    for answer in answers:
        if answer.error_m is not None:
            walks.setdefault(answer.walk_key, []).append(answer)
    ordered = sorted(walks.values(), key=lambda walk: float(np.mean([a.error_m for a in walk])))
    ranks = {title: round(share * (len(ordered) - 1)) for title, share in _SHOWN_QUANTILES.items()} if ordered else {}
    titles = {rank: title for title, rank in reversed(ranks.items())}  # fewer walks than titles: each once
    return {titles[rank]: ordered[rank] for rank in sorted(titles)}


def error_distribution(answers: Mapping[str, Sequence[Answer]], path: Path) -> None:
    """Empirical distribution of the error of every method, at covered waypoints and over all answers."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(11, 4.8), layout="constrained")
        panels = figure.subplots(1, 2, sharey=True)
        for axes, title in zip(panels, ("covered waypoints", "every answer"), strict=True):
            every = title == "every answer"
            for index, (name, found) in enumerate(answers.items()):
                errors = np.sort(errors_m(found) if every else covered_errors_m(found))
                if errors.size:
                    share = np.arange(1, errors.size + 1) / errors.size
                    label = f"{name}: mean {errors.mean():.2f}, 95 % {quantile(errors.tolist(), 0.95):.1f} m"
                    axes.step(errors, share, where="post", color=f"C{index}", lw=1.6, label=label)
            for level in (0.5, 0.95):
                axes.axhline(level, color="0.8", lw=0.8, zorder=0)
            axes.set(title=title, xlabel="horizontal error, m", xlim=(0, 20), ylim=(0, 1.005))
            axes.set_yticks([0, 0.25, 0.5, 0.75, 0.95])
            axes.legend(loc="lower right", fontsize=8)
        panels[0].set_ylabel("share of answers with no more")
        figure.savefig(path)


def tracks(walks: Mapping[str, Walk], floor: FloorFolder, title: str, path: Path) -> None:
    """Truth and answers of a few walks of one floor over its plan; answers coloured by flag."""
    with mpl.rc_context(_STYLE):
        width_m, height_m = floor.floor.width_m, floor.floor.height_m
        columns = min(len(walks), 2)
        rows = -(-len(walks) // columns)
        figure = Figure(figsize=(6.2 * columns, 6.2 * rows * height_m / width_m + 0.9), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        background = mpl.image.imread(floor.image) if floor.image else None
        for axes, (kind, walk) in zip(panels, walks.items(), strict=False):
            if background is not None:
                axes.imshow(background, extent=(0, width_m, 0, height_m), alpha=0.45, interpolation="bilinear")
            _track(axes, walk)
            mean_m = float(np.mean([a.error_m for a in walk]))
            axes.set(title=f"{kind}: {walk[0].walk[-6:]}, mean error {mean_m:.1f} m")
            axes.set_xlabel("x east, m")
            axes.set_ylabel("y north, m")
            axes.set_aspect("equal")
            _zoom(axes, walk, width_m, height_m)
        for axes in panels[len(walks) :]:
            axes.remove()
        flags = [flag for flag in FLAG_COLOURS if any(a.flag is flag for walk in walks.values() for a in walk)]
        handles = [Line2D([], [], color="k", marker="s", markersize=4, lw=1.2, label="truth, waypoints")]
        handles += [_dot(FLAG_COLOURS[flag], flag.value) for flag in flags]
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
        figure.suptitle(title, ha="left", x=0.01)
        figure.savefig(path)


def error_over_time(walks: Mapping[str, Walk], title: str, path: Path) -> None:
    """Error, 68 % radius, protection level and flag over time of a few walks."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=(11, 2.3 * len(walks) + 0.9), layout="constrained")
        panels = figure.subplots(len(walks), 1, squeeze=False).ravel()
        for axes, (kind, walk) in zip(panels, walks.items(), strict=True):
            _timeline(axes, walk)
            axes.set(title=f"{kind}: {walk[0].floor}, {walk[0].walk[-6:]}", ylabel="m")
        panels[-1].set_xlabel("seconds since the first answer with a position; the strip below zero is the flag")
        flags = [flag for flag in FLAG_COLOURS if any(a.flag is flag for walk in walks.values() for a in walk)]
        handles, _ = panels[0].get_legend_handles_labels()
        handles += [_dot(FLAG_COLOURS[flag], flag.value) for flag in flags]
        figure.legend(handles=handles, loc="outside lower center", ncols=min(len(handles), 8))
        figure.suptitle(title, ha="left", x=0.01)
        figure.savefig(path)


def _track(axes: Axes, walk: Walk) -> None:
    truth = np.array([a.truth_xy_m for a in walk])
    places = np.array([a.xy_m for a in walk], dtype=np.float64)
    waypoints = np.array([a.truth_xy_m for a in walk if a.waypoint]).reshape(-1, 2)
    axes.plot(*np.stack((truth, places), axis=1).T, color="0.45", lw=0.5, zorder=1)  # each answer to its truth
    axes.plot(truth[:, 0], truth[:, 1], color="k", lw=1.2, zorder=2)
    axes.plot(waypoints[:, 0], waypoints[:, 1], "ks", markersize=4, zorder=4)
    axes.scatter(places[:, 0], places[:, 1], s=13, color=[FLAG_COLOURS[a.flag] for a in walk], zorder=3)
    wrong = np.array([not a.floor_right for a in walk])
    axes.scatter(places[wrong, 0], places[wrong, 1], s=45, marker="x", color="k", lw=0.8, zorder=5)


def _zoom(axes: Axes, walk: Walk, width_m: float, height_m: float) -> None:
    """The part of the floor that the walk needs, in the floor's proportions."""
    points = np.array([p for a in walk for p in (a.truth_xy_m, a.xy_m)], dtype=np.float64)
    low, high = points.min(axis=0) - 6.0, points.max(axis=0) + 6.0
    scale = max((high[0] - low[0]) / width_m, (high[1] - low[1]) / height_m, 0.12)
    middle, half = (low + high) / 2.0, 0.5 * scale * np.array([width_m, height_m])
    axes.set_xlim(middle[0] - half[0], middle[0] + half[0])
    axes.set_ylim(middle[1] - half[1], middle[1] + half[1])


def _timeline(axes: Axes, walk: Walk) -> None:
    time_s = np.array([a.time_s - walk[0].time_s for a in walk])
    error, radius, level = (
        np.array([getattr(a, name) for a in walk], dtype=np.float64)
        for name in ("error_m", "accuracy_m", "protection_level_m")
    )
    limit_m = walk[0].alert_limit_m
    axes.plot(time_s, level, color="#2166ac", lw=1.2, drawstyle="steps-post", label="protection level")
    axes.fill_between(time_s, 0, radius, color="#92c5de", alpha=0.5, lw=0, step="post", label="68 % radius")
    axes.axhline(limit_m, color="#c51b1b", lw=0.8, ls="--", label="alert limit")
    axes.plot(time_s, error, color="k", lw=1.4, label="error")
    hazardous = np.array([a.usable and a.beyond(limit_m) for a in walk])
    axes.plot(time_s[hazardous], error[hazardous], "D", color="#d6008c", ms=5, mfc="none", label="hazardous")
    top = float(np.nanmax([*error, limit_m, *np.minimum(level, 3.0 * limit_m)])) * 1.1
    axes.scatter(time_s, np.full(len(walk), -0.05 * top), s=16, marker="s", color=[FLAG_COLOURS[a.flag] for a in walk])
    axes.set(ylim=(-0.1 * top, top), xlim=(time_s[0], time_s[-1] + 1.0))


def _dot(colour: str, label: str) -> Any:
    return Line2D([], [], color=colour, marker="o", lw=0, markersize=5, label=label)
