"""A barometer tells a storey from none, and nothing that it reports can do harm."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.observations import PressureSamples
from app.pdr.pressure import RECORD_S, HeightRecord, measured

START_S = 1_700_000_000.0
RATE_HZ = 5.0


def pressed(height_m: np.ndarray, noise_hpa: float = 0.05, seed: int = 1) -> PressureSamples:
    """Samples at these heights, RATE_HZ of them a second."""
    time_s = START_S + np.arange(len(height_m)) / RATE_HZ
    noise = np.random.default_rng(seed).normal(0.0, noise_hpa, len(height_m))
    return PressureSamples(time_s, 1000.0 - 0.1178 * height_m + noise)


def risen_m(samples: PressureSamples) -> float:
    """From the first seconds to the end."""
    records = measured(HeightRecord(), samples)
    return records[-1].height_m - records[1].height_m


def resting(seconds: float) -> np.ndarray:
    return np.zeros(int(seconds * RATE_HZ))


def climbing(rise_m: float, seconds: float) -> np.ndarray:
    return np.linspace(0.0, rise_m, int(seconds * RATE_HZ))


@pytest.mark.parametrize("rise_m", [-12.0, -3.0, 3.0, 4.5, 30.0])
@given(noise_hpa=st.floats(0.01, 0.1), seed=st.integers(0, 100))
def test_a_climb_is_measured_to_a_metre(rise_m: float, noise_hpa: float, seed: int) -> None:
    way = np.concatenate([resting(10), climbing(rise_m, 20), np.full(50, rise_m)])
    assert risen_m(pressed(way, noise_hpa, seed)) == pytest.approx(rise_m, abs=1.3)


def test_a_phone_is_steady_at_rest_and_not_on_stairs() -> None:
    at_rest = measured(HeightRecord(), pressed(resting(30)))
    assert all(record.steady for record in at_rest[RECORD_S:])
    on_stairs = measured(HeightRecord(), pressed(climbing(5.0, 25)))
    assert not any(record.steady for record in on_stairs[RECORD_S:])


def test_a_leap_that_no_lift_makes_is_no_climb() -> None:
    opened = np.concatenate([resting(20), np.full(100, 9.0)])
    assert abs(risen_m(pressed(opened))) < 1.0


def test_a_single_corrupt_value_changes_nothing_that_stays() -> None:
    samples = pressed(resting(40))
    samples.pressure_hpa[100] = 900.0
    assert abs(risen_m(samples)) < 1.0


def test_a_stuck_sensor_and_a_wild_one_are_not_trusted() -> None:
    stuck = measured(HeightRecord(), pressed(resting(20), 0.0))[-1]
    wild = measured(HeightRecord(), pressed(resting(120), 3.0))[-1]
    usual = measured(HeightRecord(), pressed(resting(120), 0.1))[-1]
    assert (stuck.trusted, wild.trusted, usual.trusted) == (False, False, True)


@given(cuts=st.lists(st.integers(0, 200), max_size=6), until=st.booleans())
def test_the_same_samples_give_the_same_heights_however_they_are_cut(cuts: list[int], until: bool) -> None:
    samples = pressed(np.concatenate([resting(15), climbing(4.0, 20), np.full(25, 4.0)]))
    record = HeightRecord()
    for first, last in zip([0, *sorted(cuts)], [*sorted(cuts), 200], strict=True):
        part = PressureSamples(samples.time_s[first:last], samples.pressure_hpa[first:last])
        if until and last > first:
            record = measured(record, part, float(part.time_s[len(part.time_s) // 2]))[-1]
        record = measured(record, part)[-1]
    whole = measured(HeightRecord(), samples)[-1]
    np.testing.assert_allclose(record.seconds, whole.seconds, rtol=1e-12)


@given(
    samples=st.lists(
        st.tuples(
            st.one_of(st.floats(START_S, START_S + 60.0), st.sampled_from([math.nan, math.inf, -math.inf, 0.0])),
            st.one_of(st.floats(100.0, 1200.0), st.sampled_from([math.nan, math.inf, 0.0, -1.0, 1e9])),
        ),
        max_size=60,
    ),
    split=st.integers(0, 60),
)
def test_hostile_samples_leave_a_finite_and_short_record(samples: list[tuple[float, float]], split: int) -> None:
    record = HeightRecord()
    for part in (samples[:split], samples[split:]):
        time_s, pressure_hpa = np.array(part, dtype=np.float64).reshape(-1, 2).T
        record = measured(record, PressureSamples(time_s, pressure_hpa))[-1]
    assert len(record.seconds) <= RECORD_S
    assert np.isfinite(record.seconds).all()
    assert (np.diff(record.seconds[:, 0]) > 0.0).all()
    assert math.isfinite(record.noise_m)
