"""A paper's site built from a seed, surveyed and walked, as the methods are run on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import cycle

import numpy as np

from app.estimation.arrays import FloatArray
from app.evaluation.paper_layouts import Point
from app.evaluation.paper_sites import PaperSite
from app.evaluation.recordings import FloorFolder, RecordedWalk
from app.evaluation.replay import Coverage
from app.fusion.interface import Floor, Site
from app.observations import Position, WifiScan
from app.simulation.planned_site import FLOOR, planned_world, surveyed, walked_along
from app.simulation.recording import Recording, World
from app.simulation.trace_writer import trace_bytes
from app.survey.trace import Trace, read_trace
from app.wifi.radio_map import build_radio_map

BEGIN_S = 1_700_000_000.0
WALKS_APART_S = 10_000.0


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedSite:
    """What a method is run on. gross_s : times of the scans made wrong, by walk."""

    paper: PaperSite
    site: Site
    coverage: Coverage
    walks: tuple[RecordedWalk, ...]
    folder: FloorFolder
    world: World
    gross_s: dict[str, tuple[float, ...]] = field(default_factory=dict)


def simulated(paper: PaperSite, seed: int) -> SimulatedSite:
    """The site, surveyed and walked; the same arguments give the same."""
    world = planned_world(paper.site, paper.layout, paper.access_points, seed)
    survey_rng, *walk_rngs = np.random.default_rng([seed, 5]).spawn(1 + paper.walks)
    radio_map = build_radio_map(surveyed(world, paper.points_m, paper.samples, survey_rng))
    planned = world.building.floors[0]
    floor = Floor(FLOOR, 0, planned.width_m, planned.height_m)
    way_m, walks, gross_s = cut_off(paper.way, paper.length_m), [], {}
    for number, (rng, carrying) in enumerate(zip(walk_rngs, cycle(paper.carrying), strict=False)):
        start_s = BEGIN_S + WALKS_APART_S * number
        recording = walked_along(world, way_m, replace(paper.manner, carrying=carrying), start_s, rng)
        trace = known_all_along(recording, world, f"{paper.site}-{carrying}-{number:02d}")
        if paper.gross_errors:
            trace, gross_s[trace.trace] = with_gross_errors(trace, paper.gross_errors, paper.gross_apart_m)
        x_m, y_m = trace.waypoint_xy_m[0].tolist()
        start = Position(x_m, y_m, FLOOR) if paper.start_known else None
        walks.append(RecordedWalk(FLOOR, trace, (), np.empty((0, 2)), start))
    return SimulatedSite(
        paper=paper,
        site=Site({FLOOR: floor}, radio_map),
        coverage=Coverage({FLOOR: paper.points_m}),
        walks=tuple(walks),
        folder=FloorFolder(floor, None, ()),
        world=world,
        gross_s=gross_s,
    )


def cut_off(way: Sequence[Point], length_m: float) -> FloatArray:
    """Corner points (k, 2) of the way as far as that length."""
    points = np.array(way, dtype=np.float64)
    done_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    if done_m[-1] < length_m - 1e-6:
        raise ValueError(f"the way is {done_m[-1]:.1f} m long, not {length_m:.1f} m")
    end = [float(np.interp(length_m, done_m, axis)) for axis in points.T]
    return np.vstack([points[done_m < length_m - 1e-6], end])


def known_all_along(recording: Recording, world: World, name: str) -> Trace:
    """The recording as a trace whose waypoints are the truth at every second."""
    walk = recording.walk
    trace = read_trace(trace_bytes(recording, world.access_points, name), name)
    time_s = np.rint(1000.0 * np.arange(walk.time_s[0], walk.time_s[-1], 1.0)) / 1000.0
    places_m = np.column_stack([np.interp(time_s, walk.time_s, axis) for axis in walk.xy_m.T])
    return replace(trace, waypoint_time_s=time_s, waypoint_xy_m=places_m)


def with_gross_errors(trace: Trace, count: int, apart_m: float) -> tuple[Trace, tuple[float, ...]]:
    """The trace with scans, evenly spread, that hear what another place about so far away hears, and their times."""
    scans, times = list(trace.scans), np.array([scan.time_s for scan in trace.scans])
    places_m = np.column_stack([np.interp(times, trace.waypoint_time_s, axis) for axis in trace.waypoint_xy_m.T])
    hit = np.linspace(0, len(scans) - 1, count + 2).round().astype(int)[1:-1].tolist()
    for number in hit:
        off_m = np.linalg.norm(places_m - places_m[number], axis=1)
        other = trace.scans[int(np.argmin(np.abs(off_m - apart_m)))]
        moved_s = float(times[number]) - other.time_s
        scans[number] = WifiScan(float(times[number]), other.bssid, other.rssi_dbm, other.seen_s + moved_s)
    return replace(trace, scans=tuple(scans)), tuple(float(times[number]) for number in hit)
