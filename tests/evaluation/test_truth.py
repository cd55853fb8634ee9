from __future__ import annotations

import numpy as np
import pytest

from app.evaluation.truth import batches_of, cut_times_ms, places_at, scan_places
from app.survey.trace import Trace, read_trace

START_MS = 1_574_000_000_000


def _trace() -> Trace:
    """Waypoints at 0.5, 2.75 and 4 s; a sample every 20 ms from 0 s, so before the first, to 4.3 s."""
    lines = [f"{START_MS + t}\tTYPE_ACCELEROMETER\t{t}\t0\t9.8\t3" for t in range(0, 4300, 20)]
    lines += [f"{START_MS + t}\tTYPE_WAYPOINT\t{x}\t{y}" for t, x, y in ((500, 0, 0), (2750, 9, 0), (4000, 9, 5))]
    lines += [
        f"{START_MS + t}\tTYPE_WIFI\tx\taa:bb:cc:00:00:01\t-50\t2412\t{START_MS + t - 100}"
        for t in (100, 1500, 4000, 4200)
    ]
    return read_trace("\n".join(lines).encode(), "walk.txt")


def test_batches_end_every_second_and_at_every_waypoint() -> None:
    assert (cut_times_ms(_trace(), 1.0) - START_MS).tolist() == [500, 1500, 2500, 2750, 3500, 4000]
    assert (cut_times_ms(_trace(), 2.0) - START_MS).tolist() == [500, 2500, 2750, 4000]


def test_every_sample_up_to_the_last_waypoint_is_in_exactly_one_batch_and_in_time() -> None:
    trace = _trace()
    batches = list(batches_of(trace))
    sent = np.concatenate([batch.accelerometer.time_s for batch in batches])
    assert np.array_equal(sent, trace.accelerometer.time_s[trace.accelerometer.time_s <= trace.waypoint_time_s[-1]])
    previous_s = -np.inf
    for batch in batches:
        assert batch.end_s is not None
        assert ((batch.accelerometer.time_s > previous_s) & (batch.accelerometer.time_s <= batch.end_s)).all()
        previous_s = batch.end_s
    assert [batch.sequence for batch in batches] == list(range(len(batches)))


def test_a_sample_and_a_scan_at_the_cut_belong_to_the_batch_that_ends_there() -> None:
    batches = list(batches_of(_trace()))
    assert batches[1].accelerometer.values[-1, 0] == 1500
    assert [[round(1000 * scan.time_s) - START_MS for scan in batch.wifi] for batch in batches] == [
        [100],
        [1500],
        [],
        [],
        [],
        [4000],
    ]


def test_the_truth_is_exact_at_waypoints_linear_between_and_still_beyond() -> None:
    trace = _trace()
    times = START_MS / 1000 + np.array([0.0, 0.5, 1.625, 2.75, 3.375, 4.0, 9.0])
    assert places_at(trace, times) == pytest.approx(
        np.array([[0, 0], [0, 0], [4.5, 0], [9, 0], [9, 2.5], [9, 5], [9, 5]], dtype=float), abs=1e-5
    )


def test_scans_outside_of_the_walked_part_cover_nothing() -> None:
    assert scan_places(_trace()) == pytest.approx(np.array([[4.0, 0.0], [9.0, 5.0]]), abs=1e-5)
