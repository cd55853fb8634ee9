"""The fault campaign in new buildings: the same faults in visits to places that no setting was chosen on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from app.evaluation.campaign import Advance, Protocol, replayed
from app.evaluation.exclusions import in_play
from app.evaluation.fault_campaign import CLEAN, Answered, injected
from app.evaluation.faulty_walk import FaultyWalk, Injector, elsewhere_of
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
) -> dict[str, dict[str, Answered]]:
    """Replay so many visits to each building, as they are and with each fault, through every method.

    Parameters
    ----------
    buildings : their seeds.  protocol : its alert limit and risk.  done : called after each building.

    Returns
    -------
    Method -> fault -> answers, CLEAN first, as run_faults; the answers' `fold` is the number of the building.
    """
    found = {name: {fault: Answered([], {}) for fault in (CLEAN, *faults)} for name in methods}
    tasks = [_Task(at, one, walks, methods, faults, protocol, seed) for at, one in enumerate(buildings)]
    for of_building in in_order(_in_building, tasks, jobs):
        for name, rows in of_building.items():
            for fault, answered in rows.items():
                found[name][fault].answers.extend(answered.answers)
                found[name][fault].window.update(answered.window)
                found[name][fault].in_play.update(answered.in_play)
        done()
    return found


def _in_building(task: _Task) -> dict[str, dict[str, Answered]]:
    building = new_building(Traits.draw(task.building))
    walked = list(visits(building, task.walks))
    floors = {walk.floor for walk in building.survey}
    elsewhere = {floor: elsewhere_of([walk for walk in building.survey if walk.floor == floor]) for floor in floors}
    rows = {CLEAN: [FaultyWalk(walk, -math.inf, math.inf) for walk in walked]}
    rows |= {fault: injected(walked, elsewhere, fault, injector, task.seed) for fault, injector in task.faults.items()}
    found: dict[str, dict[str, Answered]] = {name: {} for name in task.methods}
    as_it_was = {walk.trace.trace: walk for walk in walked}
    for fault, faulty in rows.items():
        keyed = {(task.number, one.walk.floor, one.walk.trace.trace): one for one in faulty}
        window = {key: (one.begin_s, one.end_s) for key, one in keyed.items()}
        playing = {key: in_play(one, as_it_was[key[2]]) for key, one in keyed.items()}
        answers = replayed(
            building.site, building.coverage, [one.walk for one in faulty], task.methods, task.protocol, task.number
        )
        for name, of_method in answers.items():
            found[name][fault] = Answered(of_method, window, playing)
    return found
