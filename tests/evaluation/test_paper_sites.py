"""The papers' sites hold what the papers say of them."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from app.evaluation.campaign import Protocol, replayed
from app.evaluation.paper_layouts import grid
from app.evaluation.paper_sites import PaperSite, paper_sites
from app.evaluation.simulated_sites import SimulatedSite, cut_off, simulated
from app.fusion.fix_assembly import Walker, no_fix
from app.fusion.interface import Method, SessionStart, Site
from app.fusion.methods import METHODS
from app.observations import Batch, Carrying, Fix, Motion
from app.simulation.layouts import Rect
from app.simulation.planned_site import planned_world

SITES = {paper.site: paper for paper in paper_sites()}
every_site = pytest.mark.parametrize("paper", SITES.values(), ids=SITES)


@lru_cache
def walked(site: str, walks: int = 1) -> SimulatedSite:
    paper = SITES[site]
    return simulated(_fewer(paper, walks), 1)


def _fewer(paper: PaperSite, walks: int) -> PaperSite:
    return replace(paper, walks=walks, samples=4)


@pytest.mark.parametrize(
    ("site", "size_m", "access_points", "points", "length_m"),
    [
        ("A-floor1", (56.0, 14.4), 12, None, 124.0),
        ("A-floor3", (56.0, 14.4), 12, None, 93.0),
        ("B-loop", (30.0, 20.0), 270, 158, 93.0),
        ("C-hall", (43.5, 11.2), 8, 487, 85.0),
        ("D-corridor", (150.0, 50.0), 64, None, 221.0),
        ("D-rooms", (150.0, 50.0), 64, None, 130.0),
        ("E-teaching", (24.0, 18.0), 30, 184, 60.6),
    ],
)
def test_sizes_and_numbers_are_the_papers(
    site: str, size_m: tuple[float, float], access_points: int, points: int | None, length_m: float
) -> None:
    paper = SITES[site]
    assert np.max(paper.layout.outline, axis=0) == pytest.approx(size_m)
    assert len(paper.access_points) == access_points
    assert points is None or len(paper.points_m) == pytest.approx(points, rel=0.12)
    assert paper.length_m == pytest.approx(length_m, abs=0.5)


@every_site
def test_every_site_belongs_to_a_method_and_says_what_was_assumed(paper: PaperSite) -> None:
    assert paper.method in METHODS
    assert paper.stated and paper.assumed


@every_site
def test_every_way_is_long_enough_and_crosses_no_wall(paper: PaperSite) -> None:
    way_m = cut_off(paper.way, paper.length_m)
    floor = planned_world(paper.site, paper.layout, paper.access_points, 1).building.floors[0]
    assert floor.walls.loss_between_db(way_m[:-1], way_m[1:]).tolist() == [0.0] * (len(way_m) - 1)
    assert way_m.min() > 0.0 and np.all(way_m.max(axis=0) < [floor.width_m, floor.height_m])


def test_a_way_is_cut_at_its_length_and_refused_where_it_is_too_short() -> None:
    corners = [(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)]
    assert cut_off(corners, 5.0).tolist() == [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0]]
    assert cut_off(corners, 7.0).tolist() == [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0]]
    with pytest.raises(ValueError, match=r"7\.0 m long"):
        cut_off(corners, 8.0)


def test_the_truth_is_known_at_every_second_and_is_within_the_way() -> None:
    (walk,) = walked("E-teaching").walks
    assert np.diff(walk.trace.waypoint_time_s) == pytest.approx(1.0)
    walked_m = np.linalg.norm(np.diff(walk.trace.waypoint_xy_m, axis=0), axis=1).sum()
    assert 0.9 * 60.6 < walked_m < 61.0
    assert walk.start is not None
    assert (walk.start.x_m, walk.start.y_m) == tuple(walk.trace.waypoint_xy_m[0])


def test_gross_errors_are_scans_of_the_same_walk_from_far_away() -> None:
    site = walked("D-rooms")
    (walk,) = site.walks
    times = site.gross_s[walk.trace.trace]
    assert len(times) == 4
    by_time = {scan.time_s: scan for scan in walk.trace.scans}
    for time_s in times:
        wrong = by_time[time_s]
        twins = [
            scan for scan in walk.trace.scans if scan is not wrong and np.array_equal(scan.rssi_dbm, wrong.rssi_dbm)
        ]
        assert len(twins) == 1
        assert abs(twins[0].time_s - time_s) > 5.0
        assert wrong.seen_s.max() <= wrong.time_s


def test_a_session_of_a_site_whose_start_is_known_is_told_it() -> None:
    site, told = walked("E-teaching"), []

    def start(session: SessionStart) -> SessionStart:
        told.append(session.start)
        return session

    def advance(state: SessionStart, batch: Batch, on: Site) -> tuple[SessionStart, Fix]:
        return state, no_fix(state, batch.end_s, Walker(None, None, 0, Motion.UNKNOWN, Carrying.UNKNOWN))

    replayed(site.site, site.coverage, site.walks, {"none": Method("none", start, advance)}, Protocol())
    assert told == [site.walks[0].start]


def test_the_same_seed_gives_the_same_walk() -> None:
    one, same = walked("E-teaching"), simulated(_fewer(SITES["E-teaching"], 1), 1)
    assert np.array_equal(one.walks[0].trace.waypoint_xy_m, same.walks[0].trace.waypoint_xy_m)
    assert np.array_equal(one.walks[0].trace.scans[3].rssi_dbm, same.walks[0].trace.scans[3].rssi_dbm)


def test_a_grid_fills_its_rectangles_at_about_the_spacing() -> None:
    points = grid([Rect(0.0, 0.0, 6.0, 2.0), Rect(6.0, 0.0, 7.0, 1.0)], 1.0)
    assert len(points) == 13
    assert points.min(axis=0).tolist() == [0.5, 0.5]
    assert points.max(axis=0).tolist() == [6.5, 1.5]
