"""Tracks as all of a session's evidence has them: the stored fixes, each moved to where the walker is now known to
have been."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable, Mapping, Sequence
from typing import Any

import orjson

from app.errors import NotFound
from app.fusion.evidence_codec import Evidence, decode_evidence
from app.fusion.interface import Method, Site
from app.fusion.smoothed_track import KnownThen, SmoothedTrack
from app.fusion.track_smoothing import smoothed
from app.fusion.walk_timeline import Moment
from app.observations import Position, RadioFix, Step
from app.services.fix_document import position_document
from app.services.site_cache import SiteCache
from app.storage.session_rows import EvidenceRow, FixRow, SessionRow, SessionRows


class SmoothedTracks:
    """Tracks of sessions, smoothed by everything that was measured up to now.

    Parameters
    ----------
    live : gives the session, or raises NotFound or Expired.
    """

    def __init__(
        self,
        rows: SessionRows,
        sites: SiteCache,
        live: Callable[[str], Awaitable[SessionRow]],
        methods: Mapping[str, Method],
    ) -> None:
        self._rows = rows
        self._sites = sites
        self._live = live
        self._with_walls = frozenset(name for name, method in methods.items() if method.walls)
        # a session of hours takes seconds: one at a time, beside the event loop, so that no phone waits for it
        self._lane = asyncio.Lock()

    async def track(
        self, session: str, after: int, limit: int, from_ms: int | None = None, to_ms: int | None = None
    ) -> list[FixRow]:
        """Fixes after a sequence, in order, at most limit, with `t` within the bounds.

        Raises
        ------
        NotFound, Expired : there is no such session, or it is over.
        DependencyDown : the database cannot be reached.
        """
        row = await self._live(session)
        async with self._lane:
            page = await self._rows.read_track(session, after, limit, from_ms, to_ms)
            told = await self._rows.read_evidence(session)
            if page and (not told or told[-1].sequence < page[-1].sequence):
                raise NotFound("the session was erased meanwhile")
            site = await self._sites.site(row.venue, row.revision)
            return await asyncio.to_thread(_smoothed_page, page, told, row.risk, site, row.method in self._with_walls)


def _smoothed_page(
    page: Sequence[FixRow], told: Sequence[EvidenceRow], risk: float, site: Site, walls: bool
) -> list[FixRow]:
    """The page by the evidence of the whole session; fixes without any written down stay as they are.

    walls : whether they had a part in the fixes, on floors that have a plan.
    """
    measured: list[Step | RadioFix] = []
    moments: list[Moment] = []
    known: dict[int, tuple[int, Evidence]] = {}
    for row in told:
        if row.evidence is None or row.t_ms is None:
            continue
        evidence = decode_evidence(row.evidence)
        known[row.sequence] = len(moments), evidence
        measured += evidence.measured
        moments.append(Moment(row.t_ms / 1000.0, evidence.motion))
    track = smoothed(measured, moments) if moments else None
    rows = []
    for fix in page:
        document = orjson.loads(fix.body) | {"smoothed": True}
        if track is not None and document["position"] is not None and fix.sequence in known:
            _move(document, track, *known[fix.sequence], risk, site, walls)
        rows.append(FixRow(fix.sequence, fix.t_ms, orjson.dumps(document)))
    return rows


def _move(
    fix: dict[str, Any], track: SmoothedTrack, at: int, evidence: Evidence, risk: float, site: Site, walls: bool
) -> None:
    """Replace what the track says of a Fix; what was found at the time (flag, phases, speed) stays as it was."""
    position, integrity = fix["position"], fix["integrity"]
    then = KnownThen(
        position["x"],
        position["y"],
        integrity["protection_level"],
        integrity["alert_limit"],
        integrity["if2"],
        integrity["if3"],
        evidence.floor_certain,
        evidence.unsurveyed_m2,
        walls and site.space(track.floor[at]).walled,
    )
    told = track.answer(at, risk, then)
    x_m, y_m = told.xy_m.tolist()
    heading_rad = float(track.heading_rad[at])
    integrity["usable"] = told.usable
    integrity["protection_level"] = told.level_m
    fix |= {
        "position": position_document(Position(x_m, y_m, track.floor[at]), site),
        "accuracy": told.accuracy_m,
        "covariance": told.covariance_m2.tolist(),
        "heading": heading_rad if math.isfinite(heading_rad) else None,
    }
