"""Looking up values in arrays that are in order."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.estimation.arrays import looked_up, position_of, within


@given(st.lists(st.integers(0, 20)), st.sets(st.integers(0, 20)))
def test_a_value_is_found_where_it_stands_or_not_at_all(value: list[int], others: set[int]) -> None:
    ascending = sorted(others)
    at, found = looked_up(np.array(value, np.int64), np.array(ascending, np.int64))
    assert found.tolist() == [one in others for one in value]
    assert [ascending[place] for place in at[found].tolist()] == [one for one in value if one in others]
    assert within(np.array(value, np.int64), np.array(ascending, np.int64)).tolist() == found.tolist()
    places = [position_of(one, np.array(ascending, np.int64)) for one in value]
    assert places == [ascending.index(one) if one in others else -1 for one in value]
