"""The fault campaign in new buildings: the same faults in visits to places that no setting was chosen on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.evaluation.campaign import Advance, Protocol
from app.evaluation.fault_campaign import ByFault, faulted, pooled
from app.evaluation.faulty_walk import Injector
from app.evaluation.new_buildings import new_building, visits
from app.evaluation.parallel import in_order
from app.fusion.interface import Method
from app.simulation.varied_world import Traits


@dataclass(frozen=True, slots=True)
class _Task:
    number: int
    building: int
    walks: int
    methods: Mapping[str, Method]
    faults: Mapping[str, Injector]
    protocol: Protocol
    seed: int


def run_simulated_faults(
    buildings: Sequence[int],
    walks: int,
    methods: Mapping[str, Method],
    faults: Mapping[str, Injector],
    protocol: Protocol,
    seed: int,
    jobs: int = 1,
    done: Advance = lambda: None,
) -> ByFault:
    """Replay so many visits to each building, as they are and with each fault, through every method.

    Parameters
    ----------
    buildings : their seeds.  protocol : its alert limit and risk.  done : called after each building.

    Returns
    -------
    As run_faults; the answers' `fold` is the number of the building.
    """
    tasks = [_Task(at, one, walks, methods, faults, protocol, seed) for at, one in enumerate(buildings)]
    of_buildings = []
    for found in in_order(_in_building, tasks, jobs):
        of_buildings.append(found)
        done()
    return pooled(of_buildings)


def _in_building(task: _Task) -> ByFault:
    building = new_building(Traits.draw(task.building))
    walked = list(visits(building, task.walks))
    survey, site = building.survey, building.site
    return faulted(site, survey, walked, task.methods, task.faults, task.protocol, task.number, task.seed)
