"""The wire schemas of quality reports."""

from __future__ import annotations

from pydantic import BaseModel


class PlacementErrorBody(BaseModel):
    """Of single scans, placed by the walks that they are not of. `scans`: tried; `unplaced`, `wrong_floor`: of these.
    m; null where there is nothing to tell from."""

    scans: int
    unplaced: int
    wrong_floor: int
    mean: float | None
    median: float | None
    quantile_95: float | None


class SupportedRiskBody(BaseModel):
    """What the calibration sample supports. `smallest`: 1 / (`walks` + 1).  `levels`: by risk, what a further walk's
    worst scan stays within, m; null where there are too few walks for it."""

    walks: int
    smallest: float
    levels: dict[str, float | None]


class LevelBody(BaseModel):
    """What the default method promises of the same scans, one by one. `risk`: that of the levels.  `learnt_from`: walks
    that this version's variances were learnt from, 0: the defaults.  `median`: m.  `inside`: share of errors within
    their level; null where there is nothing to tell from."""

    risk: float
    learnt_from: int
    median: float | None
    inside: float | None


class ErrorCellBody(BaseModel):
    """A square of the error map, by its centre. `level`: mean protection level, m."""

    x: float
    y: float
    error: float
    worst: float
    level: float
    scans: int
    walks: int


class CoverageGapBody(BaseModel):
    """Connected area that nothing was surveyed near: the place in it farthest from any scan, how far that is, and west,
    south, east and north of all of it."""

    x: float
    y: float
    area: float
    distance: float | None
    bounds: list[float]


class CoverageBody(BaseModel):
    """`reach`: a scan covers what is within, m.  `basis`: what counts: by the `plan` all that lies within its outline
    and in no room that nobody went into, else the whole `frame`.  `covered`: share of `area`.  The largest gaps first.
    """

    reach: float
    basis: str
    area: float
    covered: float
    gaps: list[CoverageGapBody]


class PlaceBody(BaseModel):
    """A reference point."""

    floor: str
    x: float
    y: float


class LookAlikeBody(BaseModel):
    """Two places far apart that sound alike."""

    places: list[PlaceBody]
    apart: float
    signal_distance: float


class LookAlikesBody(BaseModel):
    """`signal_limit`: what neighbouring places differ by, and these do not exceed.  The most alike first."""

    signal_limit: float
    pairs: int
    listed: list[LookAlikeBody]


class FloorQualityBody(BaseModel):
    """One floor."""

    floor: str
    width: float
    height: float
    scans: int
    risk: SupportedRiskBody
    error: PlacementErrorBody
    level: LevelBody
    cell: float
    cells: list[ErrorCellBody]
    coverage: CoverageBody
    look_alikes: LookAlikesBody


class UnsteadyBody(BaseModel):
    """An access point that differs from walk to walk at the same place. `spread`: dB, told from so many `repeats`."""

    bssid: str
    spread: float
    repeats: int


class AccessPointsBody(BaseModel):
    """`judged`: heard often enough to tell.  `limit`: twice the median spread, beyond which one is listed."""

    known: int
    judged: int
    median_spread: float | None
    limit: float | None
    unsteady: int
    listed: list[UnsteadyBody]


class ResurveyBody(BaseModel):
    """A square by its centre, `size` m wide, in which scans have become unlike the map: survey here again.

    `ratio`: how many times as unlike as survey scans are when their walks are left out.  `score`: that, standardised.
    `sessions`: estimated, and `visits` of these, `scans`, and those `unfit` to the track.  `surveyed`: scans of the
    survey there.  `last`: Unix ms, server's clock.
    """

    floor: str
    x: float
    y: float
    size: float
    reason: str
    ratio: float
    score: float
    sessions: int
    visits: int
    scans: int
    unfit: int
    surveyed: int
    last: int


class WatchedPlaceBody(BaseModel):
    """Where a watched access point was heard strongest."""

    floor: str
    x: float
    y: float
    bssid: str
    reason: str


class DriftBody(BaseModel):
    """What use has shown since. `since`: from when on it is counted, Unix ms, server's clock.  `squares`: that were
    used enough to tell.  `score`: how many times as unlike the map scans are in those of them that were surveyed, as
    left-out survey scans are; null of none.  `resurvey`: the most evident first.  `watched_share`: of the map's access
    points, those on its watch list."""

    since: int
    score: float | None
    squares: int
    resurvey: list[ResurveyBody]
    watched_share: float
    access_points: list[WatchedPlaceBody]


class QualityBody(BaseModel):
    """The report of a version. `created`: Unix ms, server's clock.  `fingerprints`: of WiFi."""

    version: int
    created: int
    fingerprints: int
    walks: int
    risk: SupportedRiskBody
    error: PlacementErrorBody
    level: LevelBody
    access_points: AccessPointsBody
    drift: DriftBody
    floors: list[FloorQualityBody]
