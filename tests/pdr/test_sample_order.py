from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from app.pdr.sample_order import ACC, GYR, MAG, ROT, next_sample

times = st.lists(st.integers(0, 8), max_size=6).map(sorted)


@given(times, times, times, times)
def test_samples_come_in_order_of_time_and_the_accelerometer_last_of_those_at_one(
    acc: list[int], gyr: list[int], mag: list[int], rot: list[int]
) -> None:
    time_s = [np.array(one, np.float64) for one in (acc, gyr, mag, rot)]
    taken, found = [0, 0, 0, 0], list[tuple[float, int]]()
    while True:
        a, g, m, r = taken
        stream, now_s = next_sample(time_s[ACC], a, time_s[GYR], g, time_s[MAG], m, time_s[ROT], r)
        if now_s == np.inf:
            break
        taken[stream] += 1
        found.append((now_s, (GYR, MAG, ROT, ACC).index(stream)))
    assert taken == [len(acc), len(gyr), len(mag), len(rot)]
    assert found == sorted(found)
