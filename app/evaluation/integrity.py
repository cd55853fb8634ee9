"""Whether the protection level keeps its promise, and what it costs: figures over the answers of many walks.

The words are those of the Stanford diagram: an answer is misleading when the truth is beyond its level although it is
usable, hazardous when the truth is beyond the alert limit although it is usable.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from app.evaluation.bootstrap import most_walks, share_bounds
from app.evaluation.replay import Answer
from app.evaluation.scoring import correlation, quantile, ratio
from app.observations import Flag

ALERT_LIMITS_M = (10.0, 15.0, 20.0)
"""At which availability and hazard are judged, whatever limit the session asked for."""


@dataclass(frozen=True, slots=True)
class Share:
    """A share of answers with what the walks say of its certainty.

    share : in [0, 1], NaN of nothing.  lower_95, upper_95 : one-sided, by bootstrap over walks, NaN where that is blind
    (bootstrap.py).  walks : in how many it happened at all.  walks_upper_95 : bound of the share of such walks.
    """

    share: float
    lower_95: float
    upper_95: float
    walks: int
    walks_upper_95: float


@dataclass(frozen=True, slots=True)
class AtLimit:
    """What a session with this alert limit would have been told. misleading and hazardous are shares of all answers."""

    alert_limit_m: float
    available: Share
    available_covered: Share
    misleading: Share
    hazardous: Share


@dataclass(frozen=True, slots=True)
class Integrity:
    """Figures of one method.

    inside_level : positions with the truth inside the level; promised is 1 - risk.  level_median_m : sharpness.
    false_alert_walks : clean walks with flag fault.
    """

    walks: int
    inside_level: Share
    inside_level_covered: Share
    level_median_m: float
    level_median_covered_m: float
    level_error_correlation: float
    false_alert_walks: int
    false_alert_share: float
    false_alert_upper_95: float
    limits: tuple[AtLimit, ...]


def usable_at(answer: Answer, limit_m: float) -> bool:
    """Whether the answer would be usable at this alert limit: no fault, and the level within the limit."""
    level_m = answer.protection_level_m
    return answer.flag is not Flag.FAULT and level_m is not None and level_m <= limit_m


def integrity(answers: Sequence[Answer], limits_m: Sequence[float] = ALERT_LIMITS_M) -> Integrity:
    """Judge the levels of one method's answers over one or many clean walks."""
    placed = [a for a in answers if a.error_m is not None]
    levels = [(a.protection_level_m, a.error_m, a.covered) for a in placed if a.protection_level_m is not None]
    walks = len({a.walk_key for a in answers})
    warned = len({a.walk_key for a in answers if a.flag is Flag.FAULT})
    return Integrity(
        walks=walks,
        inside_level=share_of(placed, _inside),
        inside_level_covered=share_of([a for a in placed if a.covered], _inside),
        level_median_m=quantile([level_m for level_m, _, _ in levels], 0.5),
        level_median_covered_m=quantile([level_m for level_m, _, covered in levels if covered], 0.5),
        level_error_correlation=correlation(
            [(level_m, error_m) for level_m, error_m, _ in levels if error_m is not None]
        ),
        false_alert_walks=warned,
        false_alert_share=ratio(warned, walks),
        false_alert_upper_95=most_walks(warned, walks),
        limits=tuple(_at_limit(answers, limit_m) for limit_m in limits_m),
    )


def share_of(answers: Sequence[Answer], counts: Callable[[Answer], bool]) -> Share:
    """The share of the answers that count, with its bounds."""
    whole = Counter(a.walk_key for a in answers)
    part = Counter(a.walk_key for a in answers if counts(a))
    lower, upper = share_bounds([part[walk] for walk in whole], list(whole.values()))
    return Share(ratio(part.total(), whole.total()), lower, upper, len(part), most_walks(len(part), len(whole)))


def _at_limit(answers: Sequence[Answer], limit_m: float) -> AtLimit:
    def usable(answer: Answer) -> bool:
        return usable_at(answer, limit_m)

    return AtLimit(
        alert_limit_m=limit_m,
        available=share_of(answers, usable),
        available_covered=share_of([a for a in answers if a.scanned and a.covered], usable),
        misleading=share_of(answers, lambda a: usable(a) and a.beyond(a.protection_level_m)),
        hazardous=share_of(answers, lambda a: usable(a) and a.beyond(limit_m)),
    )


def _inside(answer: Answer) -> bool:
    return not answer.beyond(answer.protection_level_m)
