from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.integrity.map_drift import ALPHA, DRIFT, TOLERATED, drifted, log_evidence

WITHIN, BETWEEN = 0.12, 0.30


def test_evidence_is_the_ratio_of_the_likelihoods_of_a_changed_and_an_unchanged_square() -> None:
    def density(value: float, variance: float) -> float:
        return math.exp(-0.5 * value**2 / variance) / math.sqrt(2.0 * math.pi * variance)

    shift, noise, known_to = 1.3, 0.02, 0.05
    changed = density(shift - TOLERATED, noise + known_to + DRIFT**2)
    expected = math.log(changed / density(shift - TOLERATED, noise + known_to))
    found = log_evidence(np.array([shift]), np.array([noise]), np.array([known_to]))
    np.testing.assert_allclose(found, [expected])


@given(st.floats(-5.0, TOLERATED), st.floats(1e-3, 1.0), st.floats(0.0, 1.0))
def test_what_is_tolerated_is_no_evidence_however_often_it_is_seen(shift: float, noise: float, known_to: float) -> None:
    assert log_evidence(np.array([shift]), np.array([noise]), np.array([known_to]))[0] <= 0.0


def test_the_most_evident_square_must_outdo_their_number_and_each_further_one_less() -> None:
    needed = [math.log(10.0 / ALPHA / rank) for rank in (1, 2, 3)]
    nothing = [0.0] * 7
    assert drifted(np.array([needed[0] - 1e-6, *nothing, 0.0, 0.0])).tolist() == []
    assert drifted(np.array([0.0, needed[0] + 1e-6, *nothing, 0.0])).tolist() == [1]
    together = np.array([needed[2] + 0.01, 0.0, needed[2] + 0.02, *nothing[:-1], needed[2] + 0.03])
    assert drifted(together).tolist() == [9, 2, 0]
    assert drifted(np.empty(0)).tolist() == []


def test_looking_after_every_visit_names_squares_of_unchanged_buildings_in_no_more_than_the_promised_share() -> None:
    rng = np.random.default_rng(11)
    versions, squares, visits = 300, 60, 40
    false = 0
    for _ in range(versions):
        walks = rng.integers(0, 8, squares)
        place = rng.normal(0.0, math.sqrt(BETWEEN), squares)
        survey = place + rng.normal(0.0, 1.0, squares) * np.sqrt(WITHIN / np.maximum(walks, 1))
        known_to = 1.0 / (1.0 / BETWEEN + walks / WITHIN)
        expected = known_to * (walks / WITHIN) * survey
        # as bad as is tolerated, everywhere: the worst that is no drift
        use = place[:, np.newaxis] + TOLERATED + rng.normal(0.0, math.sqrt(WITHIN), (squares, visits))
        mean = np.cumsum(use, axis=1) / np.arange(1, visits + 1)
        named = (
            len(drifted(log_evidence(mean[:, n - 1] - expected, np.full(squares, WITHIN / n), known_to)))
            for n in range(5, visits + 1)
        )
        false += any(named)
    assert false / versions <= ALPHA
