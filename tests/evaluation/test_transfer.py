from __future__ import annotations

from pathlib import Path

import pytest

from app.errors import InvalidInput
from app.evaluation.campaign import Protocol, read_walks
from app.evaluation.recordings import floor_folders
from app.evaluation.transfer import (
    SHIPPED,
    FloorWalks,
    factor_holding,
    floor_walks,
    judged,
    learnt_levels,
    leave_one_floor_out,
    replays,
)
from app.evaluation.trust_rows import RISKS
from app.fusion.surefix_settings import SurefixSettings
from tests.evaluation.answers import answer

PROTOCOL = Protocol(folds=2, tested=(0, 1), limit=1)


@pytest.fixture(scope="module")
def floors(small_site: Path) -> list[FloorWalks]:
    folders = floor_folders(small_site)
    walks = read_walks(folders)
    return [floor_walks(folder, walks, PROTOCOL) for folder in folders]


def test_a_factor_is_the_smallest_that_holds_the_promise() -> None:
    answers = [answer(error_m, protection_level_m=10.0) for error_m in range(1, 101)]
    factor = factor_holding(answers, 0.05)
    inside = [a.error_m is not None and a.error_m <= 10.0 * factor for a in answers]
    assert sum(inside) / len(inside) >= 0.95
    assert factor == pytest.approx(9.6)


def test_no_factor_makes_up_for_a_wrong_floor() -> None:
    answers = [answer(1.0, floor_right=number > 1) for number in range(10)]
    assert factor_holding(answers, 0.05) == float("inf")


def test_no_walk_is_in_the_map_that_it_is_walked_on(floors: list[FloorWalks]) -> None:
    for floor in floors:
        for fold in floor.folds:
            assert fold.site.radio_map is not None
            assert fold.site.radio_map.floors == (floor.floor,)
            assert {walk.floor for walk in fold.walked} == {floor.floor}
        names = [{walk.trace.trace for walk in fold.walked} for fold in floor.folds]
        assert not names[0] & names[1]


def test_a_floor_is_learnt_from_its_own_walks_and_judged_on_every_floor(floors: list[FloorWalks]) -> None:
    offered: list[str] = []

    def learn(floor: FloorWalks) -> SurefixSettings:
        offered.append(floor.floor)
        return SurefixSettings(tails=((0.01, 5.0), (0.05, 5.0)))

    found = list(leave_one_floor_out(floors, learn))
    assert offered == ["F1", "F2"]
    pairs = [(one.learnt_on, one.judged_on) for one in found]
    assert pairs == [(learnt, floor) for floor in ("F1", "F2") for learnt in (SHIPPED, "F1", "F2")]
    wide, shipped = (found[at].row.at_risk[0].level_median_m for at in (1, 0))
    assert wide > 3.0 * shipped


def test_learnt_levels_hold_on_the_floor_that_they_were_learnt_on(floors: list[FloorWalks]) -> None:
    settings = learnt_levels(floors[0], lasting=(0.6,), distance_weight=(1.0, 1.6))
    assert settings.distance_weight in (1.0, 1.6)
    assert [risk for risk, _ in settings.tails] == sorted(RISKS)
    row = judged({"own": settings}, floors[0])["own"]
    for risk, one in zip(row.risks, row.at_risk, strict=True):
        assert one.inside_level.share >= 1.0 - risk


def test_a_bar_counts_to_the_number_of_replays(small_site: Path) -> None:
    folders, reported = floor_folders(small_site), list[int]()
    walks = read_walks(folders)
    floors = [floor_walks(folder, walks, PROTOCOL, done=lambda: reported.append(1)) for folder in folders]
    list(leave_one_floor_out(floors, learnt_levels))
    assert len(reported) == replays(2, sum(len(fold.walked) for floor in floors for fold in floor.folds))


def test_one_floor_alone_cannot_be_left_out(floors: list[FloorWalks]) -> None:
    with pytest.raises(InvalidInput, match="two floors"):
        list(leave_one_floor_out(floors[:1], learnt_levels))
