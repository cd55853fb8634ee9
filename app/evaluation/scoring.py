"""Figures over the answers of one or many walks. Where ISO/IEC 18305 has a name for one, ISO_18305 gives it."""

from __future__ import annotations

import math
import statistics
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields

from app.evaluation.consistency import Consistency, consistency
from app.evaluation.replay import Answer
from app.observations import Flag

ISO_18305 = {
    "mean_m": "mean of the horizontal error magnitude (8.4)",
    "rms_m": "RMS horizontal error (8.7)",
    "median_m": "circular error probable, CEP (8.9)",
    "p95_m": "circular error 95 %, CE95 (8.9)",
    "floor_right": "floor detection probability (8.2)",
    "batch_ms_p50": "latency (8.14), the part of the server's method",
    "positioned": "availability (8.16.2)",
}
"""Our field -> the name in ISO/IEC 18305:2016 and its clause."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Horizontal errors in metres; NaN of none."""

    n: int
    mean_m: float
    rms_m: float
    median_m: float
    p75_m: float
    p95_m: float


@dataclass(frozen=True, slots=True)
class Score:
    """What the answers are worth. Shares are in [0, 1], NaN of nothing.

    waypoints : where the truth is exact.  positioned : share of answers with a position.  inside_68,
    inside_protection_level : share of positions with the truth inside the radius; promised are 0.68 and 1 - risk.
    available : share of answers that are usable.  misleading : usable, yet beyond the protection level.  hazardous :
    usable, yet beyond the alert limit. A wrong floor is outside of every radius.
    """

    walks: int
    answers: int
    waypoints_covered: Errors
    waypoints: Errors
    every_answer: Errors
    positioned: float
    positioned_after_first_scan: float
    floor_right: float
    inside_68: float
    inside_protection_level: float
    protection_level_median_m: float
    level_error_correlation: float
    available: float
    available_covered: float
    misleading: float
    hazardous: float
    flags: dict[str, int]
    walks_with_fault_flag: float
    consistency: Consistency
    batch_ms_p50: float
    batch_ms_p99: float


def quantile(values: Sequence[float], q: float) -> float:
    """The value at rank floor(q n), no interpolation; NaN of none."""
    ordered = sorted(values)
    return ordered[min(int(q * len(ordered)), len(ordered) - 1)] if ordered else math.nan


def errors_of(values_m: Sequence[float]) -> Errors:
    """Summary of horizontal errors."""
    if not values_m:
        return Errors(0, *(math.nan for _ in fields(Errors)[1:]))
    return Errors(
        n=len(values_m),
        mean_m=statistics.fmean(values_m),
        rms_m=math.sqrt(statistics.fmean(value * value for value in values_m)),
        median_m=quantile(values_m, 0.5),
        p75_m=quantile(values_m, 0.75),
        p95_m=quantile(values_m, 0.95),
    )


def errors_m(answers: Iterable[Answer]) -> list[float]:
    """Horizontal errors of the answers with a position."""
    return [a.error_m for a in answers if a.error_m is not None]


def covered_errors_m(answers: Iterable[Answer]) -> list[float]:
    """Errors where they can be judged best: at waypoints, where the truth is exact, that the survey covers."""
    return errors_m(a for a in answers if a.waypoint and a.covered)


def ratio(part: int, whole: int) -> float:
    """A share; NaN of nothing."""
    return part / whole if whole else math.nan


def correlation(pairs: Sequence[tuple[float, float]]) -> float:
    """Pearson's, of levels and errors; NaN of fewer than three pairs and where either is the same all along."""
    levels, errors = [level for level, _ in pairs], [error for _, error in pairs]
    if len(pairs) < 3 or min(levels) == max(levels) or min(errors) == max(errors):
        return math.nan
    return statistics.correlation(levels, errors)


def score(answers: Sequence[Answer]) -> Score:
    """Score the answers of one or many walks."""
    after = [a for a in answers if a.scanned]
    covered_after = [a for a in after if a.covered]
    placed = [a for a in answers if a.error_m is not None]
    levelled = [
        (a.protection_level_m, a.error_m) for a in placed if a.protection_level_m is not None and a.error_m is not None
    ]
    usable = [a for a in answers if a.usable]
    walks = {a.walk_key for a in answers}
    warned = {a.walk_key for a in answers if a.flag is Flag.FAULT}
    spent_ms = [1000.0 * a.spent_s for a in answers]
    return Score(
        walks=len(walks),
        answers=len(answers),
        waypoints_covered=errors_of(covered_errors_m(answers)),
        waypoints=errors_of(errors_m(a for a in answers if a.waypoint)),
        every_answer=errors_of(errors_m(answers)),
        positioned=ratio(len(placed), len(answers)),
        positioned_after_first_scan=ratio(sum(a.error_m is not None for a in after), len(after)),
        floor_right=ratio(sum(a.floor_right for a in placed), len(placed)),
        inside_68=ratio(sum(not a.beyond(a.accuracy_m) for a in placed), len(placed)),
        inside_protection_level=ratio(sum(not a.beyond(a.protection_level_m) for a in placed), len(placed)),
        protection_level_median_m=quantile([level for level, _ in levelled], 0.5),
        level_error_correlation=correlation(levelled),
        available=ratio(len(usable), len(answers)),
        available_covered=ratio(sum(a.usable for a in covered_after), len(covered_after)),
        misleading=ratio(sum(a.beyond(a.protection_level_m) for a in usable), len(answers)),
        hazardous=ratio(sum(a.beyond(a.alert_limit_m) for a in usable), len(answers)),
        flags=dict(sorted(Counter(a.flag.value for a in answers).items())),
        walks_with_fault_flag=ratio(len(warned), len(walks)),
        consistency=consistency(answers),
        batch_ms_p50=quantile(spent_ms, 0.5),
        batch_ms_p99=quantile(spent_ms, 0.99),
    )
