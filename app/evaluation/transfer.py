"""Leave one floor out: settings learnt from the walks of one floor alone, judged on another with that floor's own map.

What is learnt are those constants of `surefix` that decide how large a level is: the share of a fix's variance that
lasts, the weight of the signal distance, and for each risk the factor by which levels exceed a Gaussian's. Whatever
else is to be tried is another `Learn`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from app.errors import InvalidInput
from app.evaluation.campaign import Advance, Protocol, coverage_of, parted, replayed, surveyed
from app.evaluation.recordings import FloorFolder, RecordedWalk
from app.evaluation.replay import Answer, Coverage
from app.evaluation.scoring import quantile
from app.evaluation.trust_rows import ALERT_LIMIT_M, RISKS, TrustRow, trust_row
from app.fusion.interface import Method, Site
from app.fusion.surefix import surefix
from app.fusion.surefix_settings import SurefixSettings

LASTING = (0.3, 0.5, 0.7)
DISTANCE_WEIGHT = (1.0, 1.6, 2.4)
"""What is tried of either."""
SHIPPED = "shipped"
"""What the settings as they come are called, which both floors had a part in."""


@dataclass(frozen=True, slots=True, eq=False)
class Fold:
    """Walks of one floor, and the site with a map of its other walks."""

    number: int
    site: Site
    coverage: Coverage
    walked: Sequence[RecordedWalk]


@dataclass(frozen=True, slots=True, eq=False)
class FloorWalks:
    """All walks of one floor, each in one fold. done : called after every replay."""

    floor: str
    folds: Sequence[Fold]
    jobs: int = 1
    done: Advance = lambda: None

    def answers(self, methods: Mapping[str, Method], risk: float) -> dict[str, list[Answer]]:
        """Of each method to every walk of the floor, none of them in its map."""
        protocol, found = (
            replace(Protocol(), risk=risk, alert_limit_m=ALERT_LIMIT_M),
            {name: list[Answer]() for name in methods},
        )
        for fold in self.folds:
            of_fold = replayed(
                fold.site, fold.coverage, fold.walked, methods, protocol, fold.number, self.jobs, self.done
            )
            for name, answers in of_fold.items():
                found[name] += answers
        return found


def floor_walks(
    folder: FloorFolder, walks: Sequence[RecordedWalk], protocol: Protocol, jobs: int = 1, done: Advance = lambda: None
) -> FloorWalks:
    """The walks of this floor among others', and a map for each fold of the protocol.

    Raises
    ------
    InvalidInput : a fold without survey or without test walks.
    """
    folds, here = list[Fold](), [walk for walk in walks if walk.floor == folder.floor.floor]
    for number in protocol.tested:
        survey, walked = parted(here, protocol, number)
        folds.append(Fold(number, surveyed([folder], survey), coverage_of(survey), walked))
    return FloorWalks(folder.floor.floor, folds, jobs, done)


Learn = Callable[[FloorWalks], SurefixSettings]
"""Settings from the walks of one floor."""


@dataclass(frozen=True, slots=True)
class Transferred:
    """learnt_on : a floor, or SHIPPED.  judged_on : a floor."""

    learnt_on: str
    judged_on: str
    settings: SurefixSettings
    row: TrustRow


def leave_one_floor_out(floors: Sequence[FloorWalks], learn: Learn) -> Iterator[Transferred]:
    """Each floor's settings on every floor, and the settings as shipped; the lines that count are those in which
    learnt_on and judged_on differ.

    Raises
    ------
    InvalidInput : fewer than two floors.
    """
    if len(floors) < 2:
        raise InvalidInput("leaving one floor out takes two floors", "floors")
    learnt = {SHIPPED: SurefixSettings()} | {floor.floor: learn(floor) for floor in floors}
    for floor in floors:
        for name, row in judged(learnt, floor).items():
            yield Transferred(name, floor.floor, learnt[name], row)


def judged(settings: Mapping[str, SurefixSettings], floor: FloorWalks) -> dict[str, TrustRow]:
    """What settings are worth on a floor with its own map, by their names."""
    methods = {name: surefix(settings=one) for name, one in settings.items()}
    by_risk = {risk: floor.answers(methods, risk) for risk in RISKS}
    return {name: trust_row({risk: found[name] for risk, found in by_risk.items()}) for name in settings}


def learnt_levels(
    floor: FloorWalks,
    lasting: Sequence[float] = LASTING,
    distance_weight: Sequence[float] = DISTANCE_WEIGHT,
) -> SurefixSettings:
    """The settings whose levels are smallest once they hold.

    For each pair of lasting share and weight: the factor that makes 1 - risk of all answers lie inside their levels,
    and the median level with it. The pair with the smallest median at the smallest risk is taken, with its factors.
    """
    tried = {
        f"{share:g} {weight:g}": replace(SurefixSettings(), lasting=share, distance_weight=weight, tails=_NONE)
        for share in lasting
        for weight in distance_weight
    }
    methods = {name: surefix(settings=settings) for name, settings in tried.items()}
    found = floor.answers(methods, min(RISKS))
    best, smallest_m = next(iter(tried)), math.inf
    for name, answers in found.items():
        level_m = factor_holding(answers, min(RISKS)) * quantile(_levels(answers), 0.5)
        if level_m < smallest_m:
            best, smallest_m = name, level_m
    tails = [(min(RISKS), factor_holding(found[best], min(RISKS)))]
    for risk in sorted(RISKS)[1:]:
        answers = floor.answers({best: methods[best]}, risk)[best]
        tails.append((risk, factor_holding(answers, risk)))
    return replace(tried[best], tails=tuple(tails))


def factor_holding(answers: Sequence[Answer], risk: float) -> float:
    """The smallest factor on the levels of these answers with which 1 - risk of the positions lie inside; a wrong floor
    is outside at any."""
    ratios = [
        a.error_m / a.protection_level_m if a.floor_right else math.inf
        for a in answers
        if a.error_m is not None and a.protection_level_m is not None
    ]
    # a little more, so that the answer that decides lies inside for certain
    return float(np.quantile(ratios, 1.0 - risk, method="higher")) * (1.0 + 1e-9) if ratios else math.nan


def replays(floors: int, walks: int) -> int:
    """How many walks are replayed for so many floors with so many test walks together: what a bar counts to."""
    learning = len(LASTING) * len(DISTANCE_WEIGHT) + len(RISKS) - 1
    return walks * (learning + len(RISKS) * (1 + floors))


_NONE = ((min(RISKS), 1.0), (max(RISKS), 1.0))
"""Levels as a Gaussian's."""


def _levels(answers: Sequence[Answer]) -> list[float]:
    return [a.protection_level_m for a in answers if a.covered and a.protection_level_m is not None]
