"""Tracks as all of a session's evidence has them: the stored fixes, each moved to where the walker is now known to
have been."""

from __future__ import annotations

import asyncio
import math
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import orjson

from app.errors import NotFound
from app.fusion.evidence_codec import Evidence, decode_evidence
from app.fusion.interface import Method, Site
from app.fusion.track_smoothing import KnownThen, SmoothedTrack, smoothed
from app.fusion.walk_timeline import Moment
from app.observations import Motion, Position, RadioFix, Step
from app.services.fix_document import position_document
from app.services.site_cache import SiteCache
from app.storage.session_rows import EvidenceRow, FixRow, SessionRow, SessionRows

OWN_LASTING = 0.6
"""Share of a stored fix's variance that the fixes around share with it, where nothing else was written down."""


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
            told = await self._told(session, bodies=False)
            if not any(isinstance(one, RadioFix) for fix in told for one in fix.evidence.measured):
                # by a method that writes no scans down: then the fixes themselves say where the walker was
                told = await self._told(session, bodies=True)
            if page and (not told or told[-1].sequence < page[-1].sequence):
                raise NotFound("the session was erased meanwhile")
            site = await self._sites.site(row.venue, row.revision)
            return await asyncio.to_thread(_smoothed_page, page, told, row.risk, site, row.method in self._with_walls)

    async def _told(self, session: str, bodies: bool) -> list[_Told]:
        rows = await self._rows.read_evidence(session, bodies)
        return await asyncio.to_thread(_decoded, rows)


@dataclass(frozen=True, slots=True)
class _Told:
    """A stored Fix by its number, the phone's time that it accounts for, and what it was made of."""

    sequence: int
    t_ms: int | None
    evidence: Evidence


def _decoded(rows: Sequence[EvidenceRow]) -> list[_Told]:
    return [_Told(row.sequence, row.t_ms, _evidence_of(row)) for row in rows]


def _evidence_of(row: EvidenceRow) -> Evidence:
    """What a Fix was made of; where that is not known, the Fix itself."""
    if row.body is None:
        return Evidence(Motion.UNKNOWN, ()) if row.evidence is None else decode_evidence(row.evidence)
    fix = orjson.loads(row.body)
    motion, position = Motion(fix["motion"]), fix["position"]
    if position is None or fix["t"] is None:
        return Evidence(motion, ())
    spread_m2 = np.array(fix["covariance"])
    own = RadioFix(
        time_s=fix["t"] / 1000.0,
        floor=position["floor"],
        xy_m=np.array([position["x"], position["y"]]),
        noise_m2=(1.0 - OWN_LASTING) * spread_m2,
        lasting_m2=OWN_LASTING * float(np.trace(spread_m2)) / 2.0,
        signal_distance=0.0,
        fits=not fix["integrity"]["if3"],
    )
    return Evidence(motion, (own,))


def _smoothed_page(page: Sequence[FixRow], told: Sequence[_Told], risk: float, site: Site, walls: bool) -> list[FixRow]:
    """walls : whether they had a part in the fixes, on floors that have a plan."""
    measured: list[Step | RadioFix] = []
    moments: list[Moment] = []
    index: dict[int, int] = {}
    for row in told:
        measured += row.evidence.measured
        if row.t_ms is not None:
            index[row.sequence] = len(moments)
            moments.append(Moment(row.t_ms / 1000.0, row.evidence.motion))
    track = smoothed(measured, moments) if moments else None
    rows = []
    for fix in page:
        document = orjson.loads(fix.body) | {"smoothed": True}
        if track is not None and document["position"] is not None:
            _move(document, track, index[fix.sequence], risk, site, walls)
        rows.append(FixRow(fix.sequence, fix.t_ms, orjson.dumps(document)))
    return rows


def _move(fix: dict[str, Any], track: SmoothedTrack, at: int, risk: float, site: Site, walls: bool) -> None:
    """Replace what the track says of a Fix; what was found at the time (flag, phases, speed) stays as it was."""
    position, integrity = fix["position"], fix["integrity"]
    contradicted = bool(integrity["if2"] or integrity["if3"])
    walls = walls and site.space(track.floor[at]).walled
    limit_m = integrity["alert_limit"]
    known = KnownThen(position["x"], position["y"], integrity["protection_level"], contradicted, limit_m, walls)
    x_m, y_m = track.place_m(at, known).tolist()
    heading_rad = float(track.heading_rad[at])
    accuracy_m, level_m = track.radii_m(at, risk, known)
    integrity["usable"] = not integrity["if3"] and level_m <= limit_m
    integrity["protection_level"] = level_m
    fix |= {
        "position": position_document(Position(x_m, y_m, track.floor[at]), site),
        "accuracy": accuracy_m,
        "covariance": track.covariance_m2[at].tolist(),
        "heading": heading_rad if math.isfinite(heading_rad) else None,
    }
