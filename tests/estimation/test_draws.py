"""Drawn numbers: the same for the same key and index, and otherwise as chance would have them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from app.estimation.draws import normals, uniform

COUNT = 20_000
WORDS = st.integers(0, 2**62)


@given(WORDS, WORDS)
def test_a_number_depends_on_key_and_index_alone_and_is_in_the_unit_interval(key: int, index: int) -> None:
    assert 0.0 < uniform(key, index) <= 1.0
    assert uniform(key, index) == uniform(key, index)


@pytest.mark.parametrize("key", [0, 1, 2, 12345])
def test_numbers_of_one_key_are_uniform_and_normal(key: int) -> None:
    drawn = np.array([uniform(key, i) for i in range(COUNT)])
    pairs = np.array([normals(key, i) for i in range(COUNT)])
    assert stats.kstest(drawn, "uniform").pvalue > 1e-4
    assert stats.kstest(pairs[:, 0], "norm").pvalue > 1e-4
    assert stats.kstest(pairs[:, 1], "norm").pvalue > 1e-4
    assert abs(np.corrcoef(pairs.T)[0, 1]) < 0.03


def test_neighbouring_keys_and_indices_have_nothing_in_common() -> None:
    table = np.array([[uniform(key, index) for index in range(2000)] for key in range(4)])
    assert np.abs(np.corrcoef(table) - np.eye(4)).max() < 0.1
    assert abs(np.corrcoef(table[0, 1:], table[0, :-1])[0, 1]) < 0.1
