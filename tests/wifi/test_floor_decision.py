"""The floor is decided by scans, and kept until they disagree for a while."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.floor_decision import FloorBelief, FloorSettings, advance_floor

FLOORS = ("B2", "B1", "F1")
LEVELS = {"B2": -2, "B1": -1, "F1": 0}


def voted(floor: str, floors: tuple[str, ...] = FLOORS) -> np.ndarray:
    return np.array([float(name == floor) for name in floors])


def after(*votes: str) -> FloorBelief:
    belief = None
    for vote in votes:
        belief = advance_floor(belief, FLOORS, voted(vote), LEVELS)
    assert belief is not None
    return belief


@pytest.mark.parametrize("floor", FLOORS)
def test_the_first_scan_decides(floor: str) -> None:
    assert after(floor).floor == floor


def test_one_or_two_scans_of_another_floor_do_not_change_the_decision() -> None:
    assert after("B1", "B1", "B1", "F1").floor == "B1"
    assert after("B1", "B1", "B1", "F1", "B1", "F1").floor == "B1"


def test_another_floor_that_persists_is_followed_within_four_scans() -> None:
    assert after(*["B1"] * 50, *["F1"] * 4).floor == "F1"
    assert after(*["F1"] * 50, *["B2"] * 4).floor == "B2"


def test_a_near_storey_is_believed_sooner_than_a_far_one() -> None:
    below, far = after(*["F1"] * 5, "B1"), after(*["F1"] * 5, "B2")
    assert below.probability[FLOORS.index("B1")] > 1.5 * far.probability[FLOORS.index("B2")]


def test_certainty_grows_with_agreement_and_falls_with_contradiction() -> None:
    assert after("F1").certainty < after("F1", "F1").certainty < after(*["F1"] * 3).certainty
    assert after("F1", "F1", "B1").certainty < after("F1", "F1").certainty


@given(votes=st.lists(st.lists(st.floats(0.01, 1.0), min_size=3, max_size=3), min_size=1, max_size=20))
def test_probabilities_stay_probabilities(votes: list[list[float]]) -> None:
    belief = None
    for vote in votes:
        belief = advance_floor(belief, FLOORS, np.array(vote) / sum(vote), LEVELS)
        assert belief.probability.sum() == pytest.approx(1.0)
        assert belief.probability.min() > 0.0
        assert 0 <= belief.decided < len(FLOORS)


def test_a_new_map_with_other_floors_carries_the_belief_over() -> None:
    belief = after("B1", "B1")
    floors = ("B1", "F1", "F2")
    carried = advance_floor(belief, floors, voted("F2", floors))
    assert carried.floor == "B1"
    gone = advance_floor(belief, ("F7",), voted("F7", ("F7",)))
    assert gone.floor == "F7"
    assert gone.certainty == 1.0


UNLIKE = FloorSettings(unlike=0.3)


def test_scans_unlike_anything_surveyed_are_never_certain_however_many_agree() -> None:
    belief = None
    for _ in range(20):
        belief = advance_floor(belief, FLOORS, voted("B1"), LEVELS, UNLIKE, unlike=0.9)
    assert belief is not None
    assert belief.certainty < 0.5


@given(unlike=st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)))
def test_the_more_unlike_the_survey_a_scan_is_the_less_its_vote_counts(unlike: tuple[float, float]) -> None:
    near, far = (advance_floor(None, FLOORS, voted("B1"), LEVELS, UNLIKE, unlike=one) for one in sorted(unlike))
    assert near.certainty >= far.certainty - 1e-12


def test_where_no_limit_was_learnt_the_distance_does_not_matter() -> None:
    near, far = (advance_floor(None, FLOORS, voted("B1"), LEVELS, unlike=one) for one in (0.0, 1.0))
    assert np.array_equal(near.probability, far.probability)
