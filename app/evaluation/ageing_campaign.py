"""Maps that age: buildings surveyed once and visited months later, when some of their access points are others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from app.evaluation.building_campaign import ByRisk
from app.evaluation.campaign import Advance, Protocol, replayed
from app.evaluation.new_buildings import new_building, visits
from app.evaluation.parallel import in_order
from app.evaluation.trust_rows import ALERT_LIMIT_M, RISKS
from app.fusion.interface import Method
from app.simulation.ageing import aged
from app.simulation.varied_world import Traits

MONTHS = (0.0, 1.0, 3.0, 6.0, 12.0, 25.0)


@dataclass(frozen=True, slots=True, eq=False)
class AfterMonths:
    """changed : share of access points that differ from those surveyed.  answers : to the same walks at each age."""

    months: float
    changed: float
    answers: ByRisk


@dataclass(frozen=True, slots=True)
class _Task:
    number: int
    seed: int
    walks: int
    method: Method
    months: Sequence[float]


def visit_ageing_buildings(
    seeds: Sequence[int],
    walks: int,
    method: Method,
    months: Sequence[float] = MONTHS,
    jobs: int = 1,
    done: Advance = lambda: None,
) -> list[AfterMonths]:
    """So many visits to each building at each age, always on the map of the first day; pooled over the buildings.

    The ways, the walkers and their phones are the same at each age. done : called after each building.
    """
    tasks = [_Task(number, seed, walks, method, months) for number, seed in enumerate(seeds)]
    buildings = []
    for found in in_order(_visit, tasks, jobs):
        done()
        buildings.append(found)
    return [
        AfterMonths(
            months=age,
            changed=sum(found[age].changed for found in buildings) / len(buildings),
            answers={risk: [a for found in buildings for a in found[age].answers[risk]] for risk in RISKS},
        )
        for age in months
    ]


def _visit(task: _Task) -> Mapping[float, AfterMonths]:
    traits = Traits.draw(task.seed)
    building = new_building(traits)
    found = {}
    for age in task.months:
        later = aged(building.world.access_points, age, task.seed)
        walked = list(visits(building, task.walks, later.access_points))
        answers: ByRisk = {}
        for risk in RISKS:
            protocol = replace(Protocol(), risk=risk, alert_limit_m=ALERT_LIMIT_M)
            methods = {task.method.method: task.method}
            answers[risk] = replayed(building.site, building.coverage, walked, methods, protocol, task.number)[
                task.method.method
            ]
        found[age] = AfterMonths(age, later.changed, answers)
    return found
