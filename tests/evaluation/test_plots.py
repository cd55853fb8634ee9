from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np

from app.evaluation.plots import error_distribution, error_over_time, shown_walks, tracks
from app.evaluation.recordings import FloorFolder
from app.fusion.interface import Floor
from app.observations import Flag
from tests.evaluation.answers import answer

WALKS = [
    answer(
        error_m=float(size * (1 + np.sin(k))),
        walk=f"walk{size}",
        time_s=float(k),
        truth_xy_m=(5.0 + k, 10.0),
        xy_m=(5.0 + k, 10.0 + size * (1 + np.sin(k))),
        flag=list(Flag)[k % len(Flag)],
        protection_level_m=None if k == 3 else 8.0,
        accuracy_m=None if k == 3 else 2.0,
    )
    for size in range(1, 8)
    for k in range(12)
]


def _ink(path: Path) -> float:
    """Share of pixels that are not white."""
    return float((mpl.image.imread(path)[..., :3].min(axis=2) < 0.9).mean())


def test_the_walks_that_are_shown_span_from_the_best_to_the_worst() -> None:
    shown = shown_walks(WALKS)
    assert {title: walk[0].walk for title, walk in shown.items()} == {
        "among the best": "walk1",
        "median": "walk4",
        "among the worst": "walk6",
        "worst": "walk7",
    }


def test_fewer_walks_than_panels_are_shown_once_each_and_none_without_positions() -> None:
    two = [a for a in WALKS if a.walk in ("walk2", "walk5")]
    assert sorted(walk[0].walk for walk in shown_walks(two).values()) == ["walk2", "walk5"]
    assert shown_walks([answer(None)]) == {}


def test_every_plot_is_drawn_with_or_without_a_plan_image(tmp_path: Path) -> None:
    image = tmp_path / "plan.png"
    mpl.image.imsave(image, np.full((40, 60, 3), 0.5))
    shown = shown_walks(WALKS)
    error_distribution({"one": WALKS, "none": [answer(None)]}, tmp_path / "cdf.png")
    error_over_time(shown, "one", tmp_path / "time.png")
    for name, background in (("with", image), ("without", None)):
        tracks(shown, FloorFolder(Floor("F1", 0, 60.0, 40.0), background, ()), "one", tmp_path / f"{name}.png")
    assert all(_ink(tmp_path / f"{name}.png") > 0.01 for name in ("cdf", "time", "without"))
    assert _ink(tmp_path / "with.png") > 0.4
