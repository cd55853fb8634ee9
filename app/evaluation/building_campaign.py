"""Methods in new buildings: every visit at every risk, building by building."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from app.evaluation.campaign import Advance, Protocol, replayed
from app.evaluation.new_buildings import new_building, visits
from app.evaluation.parallel import in_order
from app.evaluation.replay import Answer
from app.evaluation.trust_rows import ALERT_LIMIT_M, RISKS
from app.fusion.interface import Method
from app.simulation.varied_world import Traits

ByRisk = dict[float, list[Answer]]
"""Risk -> answers."""


@dataclass(frozen=True, slots=True, eq=False)
class Visited:
    """What was said in one building. survey_walks : in how many it was surveyed.  answers : by method and risk."""

    traits: Traits
    survey_walks: int
    answers: dict[str, ByRisk]


@dataclass(frozen=True, slots=True)
class _Task:
    number: int
    traits: Traits
    walks: int
    methods: Mapping[str, Method]
    risks: Sequence[float]


def visit_buildings(
    seeds: Sequence[int],
    walks: int,
    methods: Mapping[str, Method],
    risks: Sequence[float] = RISKS,
    jobs: int = 1,
    done: Advance = lambda: None,
) -> Iterator[Visited]:
    """Survey each building and replay so many visits to it, in the order of the seeds whatever the number of jobs.

    done : called after each building. The answers' `fold` is the number of the building.
    """
    tasks = [_Task(number, Traits.draw(seed), walks, methods, risks) for number, seed in enumerate(seeds)]
    for visited in in_order(_visit, tasks, jobs):
        done()
        yield visited


def pooled(visited: Sequence[Visited], method: str) -> ByRisk:
    """The answers of one method in all of these buildings."""
    risks = visited[0].answers[method]
    return {risk: [a for one in visited for a in one.answers[method][risk]] for risk in risks}


def _visit(task: _Task) -> Visited:
    building = new_building(task.traits)
    walked = list(visits(building, task.walks))
    answers: dict[str, ByRisk] = {name: {} for name in task.methods}
    for risk in task.risks:
        protocol = replace(Protocol(), risk=risk, alert_limit_m=ALERT_LIMIT_M)
        found = replayed(building.site, building.coverage, walked, task.methods, protocol, task.number)
        for name, of_method in found.items():
            answers[name][risk] = of_method
    return Visited(task.traits, len(building.survey), answers)
