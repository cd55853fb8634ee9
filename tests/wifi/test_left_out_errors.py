"""What the errors of left-out scans say of a building."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.wifi.left_out_errors import conformal_reach, persistence

SCANS, APART_M = 20, 2.0
WAY_M = np.column_stack([APART_M * np.arange(SCANS), np.zeros(SCANS)])


def persistence_of(errors: list[np.ndarray]) -> float:
    """Of walks along the same way, each with errors (SCANS, 2)."""
    return persistence(np.vstack(errors), np.tile(WAY_M, (len(errors), 1)), np.repeat(np.arange(len(errors)), SCANS))


def test_the_conformal_reach_counts_each_walk_once() -> None:
    """A thousand scans of one walk say no more than the one scan of each of the 99 others."""
    score = np.concatenate([np.full(1000, 90.5), np.arange(1.0, 100.0)])
    walk = np.concatenate([np.zeros(1000, np.int64), np.arange(1, 100)])
    assert conformal_reach(score, walk, 0.5) in (50.0, 51.0)


@given(st.integers(20, 200), st.integers(0, 2**31))
def test_a_new_walk_stays_below_the_conformal_reach_as_often_as_promised(walks: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    held = [
        rng.exponential() <= conformal_reach(rng.exponential(size=walks), np.arange(walks), 0.9) for _ in range(200)
    ]
    assert np.mean(held) > 0.8


def test_a_share_that_so_few_walks_cannot_support_gives_the_largest_score() -> None:
    assert conformal_reach(np.arange(5.0), np.arange(5), 0.95) == 4.0


@given(st.integers(0, 2**31))
def test_errors_that_a_walk_shares_last_and_those_of_each_scan_do_not(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shared = [np.tile(rng.normal(size=2), (SCANS, 1)) for _ in range(100)]
    own = [rng.normal(size=(SCANS, 2)) for _ in range(100)]
    assert persistence_of(shared) > 0.99
    assert abs(persistence_of(own)) < 0.15
    assert 0.3 < persistence_of([a + b for a, b in zip(shared, own, strict=True)]) < 0.7


def test_one_huge_error_counts_as_three_standard_deviations() -> None:
    rng = np.random.default_rng(3)
    errors = [rng.normal(size=(SCANS, 2)) for _ in range(20)]
    errors[0][5] = 3.0, 0.0
    before = persistence_of(errors)
    errors[0][5] = 1000.0, 0.0
    assert abs(persistence_of(errors) - before) < 1e-9


def test_walks_too_short_to_say_leave_errors_as_lasting_as_they_can_be() -> None:
    assert persistence(np.ones((3, 2)), np.zeros((3, 2)), np.arange(3)) == 1.0
