"""What use says of a radio map: which squares have become unlike their survey, and by how much the whole has."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from app.estimation.arrays import FloatArray
from app.integrity.map_drift import drifted, log_evidence
from app.storage.map_use_rows import UsedSquare, UseRow
from app.wifi.survey_likeness import CELL_M, Expected, Likeness

SESSION_BITS = 63
"""Of a signed integer of the database."""
LEAST_SESSIONS = 5
"""A square is judged by no fewer: one phone with a broken radio is no drift."""


def session_bit(session: str) -> int:
    """The bit that stands for a session."""
    return 1 << int.from_bytes(hashlib.sha256(session.encode()).digest()[:8]) % SESSION_BITS


def sessions_of(bits: int) -> float:
    """How many sessions have set these bits: linear counting (Whang et al. 1990); no more than 261."""
    clear = SESSION_BITS - bits.bit_count()
    return SESSION_BITS * math.log(SESSION_BITS / max(clear, 1))


@dataclass(frozen=True, slots=True)
class JudgedSquare:
    """A square of CELL_M, by its centre.

    ratio : how many times as unlike the map scans are as left-out survey scans.  score : that shift, standardised.
    sessions : estimated.  surveyed : scans of the survey there.
    """

    floor: str
    x_m: float
    y_m: float
    ratio: float
    score: float
    sessions: int
    use: UseRow
    surveyed: int

    @property
    def reason(self) -> str:
        """Why to survey here."""
        if not self.surveyed:
            return "never surveyed, and unlike what was"
        return "changed since it was surveyed"


@dataclass(frozen=True, slots=True)
class MapDrift:
    """A version. judged : squares of LEAST_SESSIONS and more.  resurvey : of these, the most evident first.

    ratio : as of a square, of all that were surveyed and are judged together; None of none.
    """

    judged: tuple[JudgedSquare, ...]
    resurvey: tuple[JudgedSquare, ...]
    ratio: float | None


def map_drift(used: Mapping[UsedSquare, UseRow], likeness: Likeness, floors: Sequence[str]) -> MapDrift:
    """Judge every square that was used enough. floors : those that the likeness counts, in order."""
    rows: dict[tuple[str, int, int], UseRow] = {}
    for square, row in used.items():
        place = (square.floor, square.east, square.north)
        rows[place] = rows[place].plus(row) if place in rows else row
    found, shift, noise, known_to = list[JudgedSquare](), list[float](), list[float](), list[float]()
    for (floor, east, north), use in sorted(rows.items()):
        sessions = round(sessions_of(use.session_bits))
        if sessions < LEAST_SESSIONS or floor not in floors:
            continue
        expected = likeness.expected(floors.index(floor), (east, north))
        shift.append(use.total / use.visits - expected.mean)
        noise.append(_noise(use, sessions, expected))
        # of a square that nobody surveyed the question is whether it is as good as those that somebody did
        known_to.append(expected.variance if expected.scans else 0.0)
        found.append(
            JudgedSquare(
                floor=floor,
                x_m=(east + 0.5) * CELL_M,
                y_m=(north + 0.5) * CELL_M,
                ratio=math.exp(shift[-1]),
                score=shift[-1] / math.sqrt(noise[-1] + known_to[-1]),
                sessions=sessions,
                use=use,
                surveyed=expected.scans,
            )
        )
    log_e = log_evidence(np.array(shift) - _usual(shift), np.array(noise), np.array(known_to))
    again = tuple(found[at] for at in drifted(log_e).tolist())
    return MapDrift(tuple(found), again, _overall(found, np.array(shift), np.array(noise) + np.array(known_to)))


def _usual(shift: Sequence[float]) -> float:
    """What all squares have in common, where it is no drift: the whole survey is a better map than one without some
    walks, so scans in use are nearer to it than left-out ones were."""
    return min(float(np.median(shift)), 0.0) if shift else 0.0


def _noise(use: UseRow, sessions: int, expected: Expected) -> float:
    """Variance of the mean over visits: of as many as there were sessions, which differ by what survey walks or these
    do, whichever is more."""
    mean = use.total / use.visits
    spread = (use.total_square - use.visits * mean**2) / max(use.visits - 1, 1)
    return max(spread, expected.within) / min(use.visits, sessions)


def _overall(found: Sequence[JudgedSquare], shift: FloatArray, variance: FloatArray) -> float | None:
    surveyed = np.array([one.surveyed > 0 for one in found], np.bool_)
    if not surveyed.any():
        return None
    return math.exp(float(np.average(shift[surveyed], weights=1.0 / variance[surveyed])))


def described_drift(drift: MapDrift, since_ms: int) -> dict[str, Any]:
    """What a quality report says of it. since_ms : from when on use is counted, server's clock, Unix."""
    return {
        "since": since_ms,
        "score": drift.ratio,
        "squares": len(drift.judged),
        "resurvey": [
            {
                "floor": one.floor,
                "x": one.x_m,
                "y": one.y_m,
                "size": CELL_M,
                "reason": one.reason,
                "ratio": one.ratio,
                "score": one.score,
                "sessions": one.sessions,
                "visits": one.use.visits,
                "scans": one.use.scans,
                "unfit": one.use.unfit,
                "surveyed": one.surveyed,
                "last": one.use.last_ms,
            }
            for one in drift.resurvey
        ],
    }
