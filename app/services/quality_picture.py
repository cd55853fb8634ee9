"""The picture of a quality report: by floor, the error over the plan, and what the survey leaves open."""

from __future__ import annotations

import io
import logging
from collections.abc import Iterable
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PatchCollection
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from app.estimation.arrays import FloatArray
from app.floorplan.walkable import Polygon
from app.services.quality_report import CELL_M, REACH_M, Findings, FloorFindings
from app.services.resurvey_overlay import RESURVEY

DOTS_PER_INCH = 130
_log = logging.getLogger(__name__)
WORST_SHOWN_M = 10.0
"""The top of the colour scale: the same on every floor and report, so that they can be compared."""
HIGHEST_SHOWN_M = 30.0
# told apart also without red or green: of Okabe and Ito's colours
_GAP, _ALIKE, _SCAN, _WALL, _ROOM = "#d55e00", "#0072b2", "#333333", "#9aa7b2", "#eef2f5"
_STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 10,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "figure.dpi": DOTS_PER_INCH,
}


def picture_of(findings: Findings, title: str) -> tuple[bytes, dict[str, Any]]:
    """A PNG, a row for each floor; and of each floor where its last panel is, for what is drawn over it later: the
    panel's `pixels` (left, top, right, bottom) and the `frame` that it shows (west, south, east, north, m)."""
    with mpl.rc_context(_STYLE):
        rows = max(len(findings.floors), 1)
        shape = [one.place.height_m / one.place.width_m for one in findings.floors] or [0.5]
        heights = [min(max(5.6 * ratio, 1.5), 8.0) + 0.8 for ratio in shape]
        figure = Figure(figsize=(18.0, sum(heights) + 0.7), layout="constrained")
        panels = figure.subplots(rows, 3, squeeze=False, height_ratios=heights)
        for (left, middle, right), one in zip(panels, findings.floors, strict=False):
            _errors(figure, left, one)
            _levels(figure, middle, one)
            _open_ends(right, one, findings)
        if not findings.floors:
            for axes in panels.ravel():
                axes.text(0.5, 0.5, "nothing was surveyed", ha="center", va="center")
                axes.set_axis_off()
        figure.suptitle(title, ha="left", x=0.01, weight="bold", parse_math=False)
        written = io.BytesIO()
        figure.savefig(written, format="png", metadata={"Software": None})
        height = figure.bbox.height
        canvases = {
            one.place.floor: _canvas(axes, height) for axes, one in zip(panels[:, 2], findings.floors, strict=False)
        }
    return written.getvalue(), canvases


def _canvas(axes: Axes, height: float) -> dict[str, list[float]]:
    box, (west, east), (south, north) = axes.get_window_extent(), axes.get_xlim(), axes.get_ylim()
    return {"pixels": [box.x0, height - box.y1, box.x1, height - box.y0], "frame": [west, south, east, north]}


def _errors(figure: Figure, axes: Axes, one: FloorFindings) -> None:
    _squares(figure, axes, one, one.cells.mean_m, WORST_SHOWN_M, "mean error, m")
    error = one.described["error"]
    told = "no walk could be left out"
    if error["mean"] is not None:
        told = f"error of a single scan: mean {error['mean']:.1f} m, 95 % within {error['quantile_95']:.1f} m"
    axes.set_title(f"{one.place.floor}: {told}")


def _levels(figure: Figure, axes: Axes, one: FloorFindings) -> None:
    _squares(figure, axes, one, one.cells.level_m, HIGHEST_SHOWN_M, "mean protection level, m")
    level = one.described["level"]
    told = "no walk could be left out"
    if level["median"] is not None:
        told = f"its level at risk {level['risk']:g}: median {level['median']:.1f} m"
        told += f", holds {100.0 * level['inside']:.1f} %"
    axes.set_title(f"{one.place.floor}: {told}")


def _squares(figure: Figure, axes: Axes, one: FloorFindings, value_m: FloatArray, highest_m: float, label: str) -> None:
    _plan(axes, one, 0.5)
    squares = [Rectangle((x - CELL_M / 2, y - CELL_M / 2), CELL_M, CELL_M) for x, y in one.cells.xy_m.tolist()]
    drawn = PatchCollection(squares, cmap="cividis_r", edgecolor="white", linewidth=0.3, alpha=0.92, zorder=3)
    drawn.set_array(value_m)
    drawn.set_clim(0.0, highest_m)
    axes.add_collection(drawn)
    figure.colorbar(drawn, ax=axes, label=label, extend="max", shrink=0.8, pad=0.01)


def _open_ends(axes: Axes, one: FloorFindings, findings: Findings) -> None:
    _plan(axes, one, 0.35)
    rows, columns = one.missing.shape
    axes.imshow(
        np.where(one.missing, 1.0, np.nan),
        extent=(0.0, columns * one.raster_m, 0.0, rows * one.raster_m),
        origin="lower",
        cmap=ListedColormap([_GAP]),
        alpha=0.45,
        interpolation="nearest",
        zorder=2,
    )
    axes.plot(*one.survey_xy_m.T, ".", color=_SCAN, ms=1.6, alpha=0.6, zorder=3)
    number = findings.floor_names.index(one.place.floor)
    here = (findings.point_floor[one.alike] == number).all(axis=1)
    ends = findings.point_xy_m[one.alike[here]]
    axes.add_collection(LineCollection(list(ends), colors=_ALIKE, linewidths=1.6, zorder=4))
    axes.plot(*ends.reshape(-1, 2).T, "o", color=_ALIKE, ms=4, mfc="white", mew=1.3, zorder=5)
    elsewhere = one.alike[~here]
    places = findings.point_xy_m[elsewhere[findings.point_floor[elsewhere] == number]]
    axes.plot(*places.T, "D", color=_ALIKE, ms=5, mfc="white", mew=1.3, zorder=5)
    coverage = one.described["coverage"]
    covered = f"{100 * coverage['covered']:.0f} % of {coverage['area']:.0f} m²"
    axes.set_title(f"{one.place.floor}: {covered} is within {REACH_M:.0f} m of a survey scan")
    handles: list[Any] = [
        Patch(color=_GAP, alpha=0.45, label="not surveyed"),
        Line2D([], [], color=_SCAN, marker=".", lw=0, ms=4, label="survey scan"),
        Line2D([], [], color=_ALIKE, marker="o", mfc="white", lw=1.6, ms=4, label="look-alike places"),
    ]
    handles.append(Patch(fc=f"{RESURVEY}66", ec=RESURVEY, lw=1.6, label="survey here again"))
    if len(elsewhere):
        label = "looks like another floor"
        handles.append(Line2D([], [], color=_ALIKE, marker="D", mfc="white", lw=0, ms=5, label=label))
    place: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.02)}
    axes.legend(handles=handles, **place, ncols=len(handles) if len(handles) <= 4 else 3, fontsize=8)


def _plan(axes: Axes, one: FloorFindings, strength: float) -> None:
    place = one.place
    if one.features:
        _outlines(axes, one.features[0], "white", 1.2)
        for room in one.features[1:]:
            _outlines(axes, room, _ROOM, 0.5)
    elif place.image is not None:
        _image(axes, place.image, (0.0, place.width_m, 0.0, place.height_m), strength)
    else:
        axes.add_patch(Rectangle((0.0, 0.0), place.width_m, place.height_m, fc="white", ec=_WALL, lw=1.2, zorder=0))
    margin_m = 0.015 * max(place.width_m, place.height_m)
    axes.set(xlim=(-margin_m, place.width_m + margin_m), ylim=(-margin_m, place.height_m + margin_m), aspect="equal")
    axes.set_axis_off()
    _scale(axes, place.width_m)


def _image(axes: Axes, png: bytes, extent: tuple[float, float, float, float], strength: float) -> None:
    """The raster plan; nothing of one whose pixels cannot be read, which only its decoder finds out."""
    try:
        picture = mpl.image.imread(io.BytesIO(png), format="png")
    except (OSError, SyntaxError, ValueError) as error:
        _log.warning("a floor's image cannot be drawn: %s", error)
        return
    axes.imshow(picture, extent=extent, alpha=strength, zorder=0)


def _outlines(axes: Axes, polygons: Iterable[Polygon], fill: str, width: float) -> None:
    for polygon in polygons:
        axes.fill(*polygon[0].T, facecolor=fill, edgecolor=_WALL, lw=width, zorder=0)
        for hole in polygon[1:]:
            axes.fill(*hole.T, facecolor="white", edgecolor=_WALL, lw=width, zorder=0)


def _scale(axes: Axes, width_m: float) -> None:
    """A bar of a round length in the lower left corner."""
    length_m = next((one for one in (50.0, 20.0, 10.0, 5.0, 2.0) if one <= width_m / 4.0), 1.0)
    axes.plot([0.0, length_m], [0.0, 0.0], color="black", lw=2.0, solid_capstyle="butt", zorder=6)
    axes.annotate(f"{length_m:.0f} m", (length_m, 0.0), (4, 0), textcoords="offset points", va="center", fontsize=8)
