"""Each paper's site: its size, access points, reference points, ways and rates as the paper has them.

What a paper leaves open is written beside it as assumed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from app.estimation.arrays import FloatArray
from app.evaluation.paper_layouts import (
    Point,
    along_sides,
    evenly,
    grid,
    hall_and_rooms,
    loop,
    office_wing,
    teaching_building,
    three_areas,
)
from app.observations import Carrying
from app.pdr.carrying_position import CLASSES
from app.simulation.layouts import Layout, Rect
from app.simulation.planned_site import Manner


@dataclass(frozen=True, slots=True)
class PaperSite:
    """One experiment of one paper.

    method : whose paper.  stated, assumed : in the paper, and beside it.  access_points : x, y, level of each.
    way, length_m : corner points, cut off at that length.  walks : repetitions, each by somebody else, carried as
    `carrying` says in turn.  gross_errors : scans of each walk that sound as from gross_apart_m away.
    start_known : whether sessions are told where they begin.
    """

    site: str
    method: str
    title: str
    stated: str
    assumed: str
    layout: Layout
    access_points: Sequence[tuple[float, float, int]]
    points_m: FloatArray
    samples: int
    way: Sequence[Point]
    length_m: float
    manner: Manner
    walks: int = 8
    carrying: Sequence[Carrying] = (Carrying.HANDHELD,)
    gross_errors: int = 0
    gross_apart_m: float = 15.0
    start_known: bool = False


def _wing_sites() -> list[PaperSite]:
    """Paper A: two floors of an office building."""
    layout = office_wing(56.0, 6.0, 2.4, 8.0)
    rooms = [(1.0, 7.2), (12.0, 7.2), (12.0, 2.0), (14.5, 2.0), (14.5, 4.5), (12.0, 4.5), (12.0, 7.2), (36.0, 7.2)]
    rooms += [(36.0, 12.5), (33.5, 12.5), (33.5, 10.0), (36.0, 10.0), (36.0, 7.2), (55.0, 7.2), (10.0, 7.2)]
    ground = PaperSite(
        site="A-floor1",
        method="integrity_ukf",
        title="Integrity UKF, floor 1",
        stated="office building; corridor, reception and computer room; way of 124 m, phone held flat",
        assumed="floor 56 x 14.4 m with 14 rooms, 12 access points, reference points every 2 m in the corridor and "
        "the two rooms with 20 samples each, a scan every 2.15 s, sensors at 50 Hz; eight walkers",
        layout=layout,
        access_points=evenly(Rect(0.0, 0.0, 56.0, 14.4), 6, 2),
        points_m=grid([layout.corridors[0], layout.rooms[2].area, layout.rooms[9].area], 2.0),
        samples=20,
        way=rooms,
        length_m=124.0,
        manner=Manner(),
    )
    upper = replace(
        ground,
        site="A-floor3",
        title="Integrity UKF, floor 3",
        stated="office building, corridor only; way of 93 m, phone held flat",
        way=[(1.0, 7.2), (55.0, 7.2), (10.0, 7.2)],
        length_m=93.0,
    )
    return [ground, upper]


def paper_sites() -> list[PaperSite]:
    """All sites, in the order of the methods' letters."""
    return [*_wing_sites(), _loop_site(), _hall_site(), *_area_sites(), _teaching_site()]


def _loop_site() -> PaperSite:
    layout = loop(30.0, 20.0, 1.8)
    around = [(0.9, 0.9), (29.1, 0.9), (29.1, 19.1), (0.9, 19.1), (0.9, 0.9)]
    return PaperSite(
        site="B-loop",
        method="two_stage_ekf",
        title="Two-stage EKF, loop corridor",
        stated="30 x 20 m, loop corridor 1.8 m wide; 158 reference points on a grid of 1.2 m, 40 samples each in four "
        "directions; 270 access points; a fix at each of the 155 steps of a loop; start known",
        assumed="156 reference points fill the corridor at 1.2 m; access points evenly on five storeys; six walkers",
        layout=layout,
        access_points=evenly(Rect(-10.0, -8.0, 40.0, 28.0), 9, 6, range(-2, 3)),
        points_m=grid(layout.corridors, 1.2),
        samples=40,
        way=around,
        length_m=92.7,
        manner=Manner(scan_every_s=0.54),
        walks=6,
        start_known=True,
    )


def _hall_site() -> PaperSite:
    way = [(3.0, 3.0), (7.5, 5.0), (7.5, 9.7), (16.5, 9.7), (16.5, 4.0), (20.5, 2.5), (22.0, 6.0), (16.5, 7.0)]
    way += [(16.5, 9.7), (35.5, 9.7), (35.5, 5.0), (40.0, 3.0), (41.0, 6.5), (35.5, 7.0), (35.5, 9.7), (42.0, 9.7)]
    return PaperSite(
        site="C-hall",
        method="dual_ukf",
        title="Dual UKF, hall, corridor and rooms",
        stated="43.5 x 11.2 m with a hall, a corridor and three rooms; 8 access points; reference points about 1 m "
        "apart, 100 samples each; a scan at each step; four carrying positions; start known",
        assumed="a way of 85 m through hall, corridor and two rooms; 20 samples a point, five walks a position",
        layout=hall_and_rooms(),
        access_points=evenly(Rect(0.0, 0.0, 43.5, 11.2), 4, 2),
        points_m=grid([Rect(0.0, 0.0, 43.5, 11.2)], 1.0),
        samples=20,
        way=way,
        length_m=85.0,
        manner=Manner(scan_every_s=0.54),
        walks=20,
        carrying=CLASSES,
        start_known=True,
    )


def _area_sites() -> list[PaperSite]:
    layout = three_areas()
    corridor = PaperSite(
        site="D-corridor",
        method="adaptive_robust_kf",
        title="Adaptive robust filter, corridor",
        stated="150 x 50 m, three areas, 64 access points along both sides of the corridor; a fix every 2 s, sensors "
        "at 50 Hz; 316 steps at constant speed; four gross errors of the fixes",
        assumed="corridors 2.4 m wide in a U, reference points every 2 m with 20 samples; 221 m; a gross error is a "
        "scan as it sounds 15 m away; eight walkers",
        layout=layout,
        access_points=along_sides(layout.corridors, 64),
        points_m=grid(layout.corridors, 2.0),
        samples=20,
        way=[(1.0, 41.8), (148.8, 41.8), (148.8, 8.2), (60.0, 8.2)],
        length_m=221.0,
        manner=Manner(scan_every_s=2.0),
        gross_errors=4,
    )
    way = [(1.0, 41.8), (18.75, 41.8), (18.75, 35.0), (16.5, 35.0), (16.5, 38.0), (18.75, 38.0), (18.75, 41.8)]
    way += [(41.25, 41.8), (41.25, 47.0), (44.0, 47.0), (44.0, 44.5), (41.25, 44.5), (41.25, 41.8)]
    way += [(63.75, 41.8), (63.75, 35.0), (61.5, 35.0), (61.5, 38.0), (63.75, 38.0), (63.75, 41.8), (80.0, 41.8)]
    entered = [room.area for room in layout.rooms if room.name in ("Cs2", "Cn5", "Cs8")]
    rooms = replace(
        corridor,
        site="D-rooms",
        title="Adaptive robust filter, rooms",
        stated="the same site, a way that goes inside rooms",
        assumed="three rooms, 130 m; as many gross errors; the rest as in the corridor",
        points_m=grid([*layout.corridors, *entered], 2.0),
        way=way,
        length_m=130.0,
    )
    return [corridor, rooms]


def _teaching_site() -> PaperSite:
    way = [(1.0, 8.3), (3.0, 8.3), (3.0, 3.0), (5.0, 3.0), (5.0, 5.5), (3.0, 5.5), (3.0, 8.3), (11.3, 8.3)]
    way += [(11.3, 17.0), (11.3, 8.3), (22.5, 8.3), (12.0, 8.3)]
    return PaperSite(
        site="E-teaching",
        method="trust_chain",
        title="Trust chain, teaching building",
        stated="430 m2; 30 access points; 184 reference points every 1.6 m, 10 samples each; a way of 60.6 m with 20 "
        "test points and a scan at each, walked ten times; sensors at 20 Hz; start known",
        assumed="24 x 18 m with two corridors and six rooms, 165 reference points at 1.6 m; a scan every 2.4 s",
        layout=teaching_building(),
        access_points=evenly(Rect(0.0, 0.0, 24.0, 18.0), 6, 5),
        points_m=grid([Rect(0.0, 0.0, 24.0, 18.0)], 1.6),
        samples=10,
        way=way,
        length_m=60.6,
        manner=Manner(rate_hz=20.0, scan_every_s=2.4),
        walks=10,
        start_known=True,
    )
