from __future__ import annotations

from dataclasses import replace

from app.evaluation.ageing_campaign import visit_ageing_buildings
from app.evaluation.building_campaign import Visited, pooled, visit_buildings
from app.evaluation.campaign import Protocol
from app.evaluation.fault_campaign import CLEAN
from app.evaluation.faults import FAULTS
from app.evaluation.replay import Answer
from app.evaluation.simulated_faults import run_simulated_faults
from app.evaluation.trust_rows import ALERT_LIMIT_M
from app.fusion.surefix import SUREFIX
from tests.evaluation.small_buildings import SMALL
from tests.odometer import ODOMETER

SEEDS = (SMALL, 61)


def _timeless(answers: list[Answer]) -> list[Answer]:
    return [replace(answer, spent_s=0.0) for answer in answers]


def _visited(jobs: int = 1) -> list[Visited]:
    return list(visit_buildings(SEEDS, 2, {"m": ODOMETER}, jobs=jobs))


def test_every_building_is_visited_so_often_at_every_risk() -> None:
    reported: list[int] = []
    found = list(visit_buildings(SEEDS, 2, {"m": ODOMETER}, (0.01, 0.05), done=lambda: reported.append(1)))
    assert [one.traits.seed for one in found] == list(SEEDS)
    assert len(reported) == 2
    for risk in (0.01, 0.05):
        answers = pooled(found, "m")[risk]
        assert len({(a.fold, a.walk) for a in answers}) == 4
        assert {a.fold for a in answers} == {0, 1}
        assert all(a.waypoint for a in answers[1:])


def test_the_answers_do_not_depend_on_the_number_of_jobs() -> None:
    alone, together = _visited(), _visited(jobs=2)
    for one, other in zip(alone, together, strict=True):
        assert {risk: _timeless(found) for risk, found in one.answers["m"].items()} == {
            risk: _timeless(found) for risk, found in other.answers["m"].items()
        }


def test_surefix_knows_where_it_is_in_a_building_that_it_never_saw() -> None:
    (visited,) = visit_buildings([SMALL], 2, {"surefix": SUREFIX}, (0.01,))
    errors_m = [a.error_m for a in visited.answers["surefix"][0.01] if a.error_m is not None]
    assert len(errors_m) > 60
    assert sum(errors_m) / len(errors_m) < 8.0


def test_on_an_ageing_map_the_same_walks_are_asked_again_and_what_was_heard_differs() -> None:
    ages = visit_ageing_buildings([SMALL], 2, SUREFIX, months=(0.0, 25.0))
    assert [one.months for one in ages] == [0.0, 25.0]
    assert ages[0].changed == 0.0 < ages[1].changed
    then, now = (one.answers[0.01] for one in ages)
    assert [(a.walk, a.truth_xy_m) for a in then] == [(a.walk, a.truth_xy_m) for a in now]
    assert [a.xy_m for a in then] != [a.xy_m for a in now]


def test_the_clean_row_of_the_faults_is_what_the_visits_are_without_them() -> None:
    faults = {"half_gone": FAULTS["half_gone"], "silence_20": FAULTS["silence_20"]}
    protocol = Protocol(alert_limit_m=ALERT_LIMIT_M)
    found = run_simulated_faults(SEEDS, 2, {"m": ODOMETER}, faults, protocol, seed=1)["m"]
    assert list(found) == [CLEAN, *faults]
    assert _timeless(found[CLEAN].answers) == _timeless(pooled(_visited(), "m")[0.01])
    for answered in found.values():
        assert len(answered.window) == 4
        assert {(a.fold, a.floor, a.walk) for a in answered.answers} == set(answered.window)
