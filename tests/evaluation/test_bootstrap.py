from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.evaluation.bootstrap import most_walks, share_bounds

PARTS = st.lists(st.tuples(st.integers(0, 40), st.integers(1, 40)), min_size=2, max_size=30)


@given(PARTS)
@settings(max_examples=40, deadline=None)
def test_bounds_are_shares_and_the_lower_is_below_the_upper(walks: list[tuple[int, int]]) -> None:
    whole = [n for _, n in walks]
    lower, upper = share_bounds([min(part, n) for part, n in walks], whole)
    assert math.isnan(lower) or 0.0 <= lower <= 1.0
    assert math.isnan(upper) or 0.0 <= upper <= 1.0
    assert not lower > upper


def test_the_same_walks_give_the_same_bounds() -> None:
    part, whole = [0, 3, 1, 9, 0, 2], [10, 12, 30, 20, 15, 9]
    assert share_bounds(part, whole) == share_bounds(part, whole)


def test_of_independent_answers_the_upper_bound_covers_the_true_share_as_often_as_it_says() -> None:
    dice = np.random.default_rng(7)
    uppers = [share_bounds(dice.binomial(20, 0.2, 60), np.full(60, 20))[1] for _ in range(200)]
    assert 0.90 <= np.mean(np.array(uppers) >= 0.2) <= 0.99


def test_errors_that_stay_together_in_one_walk_widen_the_bound() -> None:
    together = share_bounds([40] + [0] * 39, [40] * 40)
    spread = share_bounds([1] * 20 + [1] * 20, [40] * 40)
    some_spread = share_bounds([2] * 20 + [0] * 20, [40] * 40)
    assert spread == pytest.approx((0.025, 0.025))
    assert together[1] > 2.0 * some_spread[1]


def test_what_never_or_always_happened_has_no_bound_on_that_side() -> None:
    never, always = share_bounds([0, 0, 0], [5, 9, 2]), share_bounds([5, 9, 2], [5, 9, 2])
    assert math.isnan(never[1]) and never[0] == 0.0
    assert math.isnan(always[0]) and always[1] == 1.0
    assert all(map(math.isnan, share_bounds([], [])))
    assert all(map(math.isnan, share_bounds([0], [0])))


def test_the_share_of_walks_is_bounded_even_if_none_had_an_event() -> None:
    assert most_walks(0, 59) == pytest.approx(1.0 - 0.05 ** (1.0 / 59))  # the rule of three, near 5 %
    assert most_walks(1, 59) > most_walks(0, 59) > most_walks(0, 208)
    assert most_walks(4, 4) == 1.0
    assert math.isnan(most_walks(0, 0))
