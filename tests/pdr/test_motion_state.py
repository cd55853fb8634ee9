"""A phone that is still is told from one that moves by its acceleration alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.observations import AxisSamples, Batch
from app.pdr.motion_state import ShakingState, advance_shaking
from tests.pdr.phones import inertial_batch

RATE_HZ = 50.0
TILTS = [Rotation.identity(), Rotation.from_euler("XY", [0.7, -0.4]), Rotation.from_euler("X", np.pi / 2.0)]


def shaken(seconds: float, size_mps2: float, held: Rotation, begin_s: float = 0.0) -> Batch:
    """Walking: up and down twice as often as to and fro, with a hand's tremor."""
    rng = np.random.default_rng(1)
    time_s = begin_s + np.arange(0.0, seconds, 1.0 / RATE_HZ)
    phase = 2.0 * np.pi * 1.8 * time_s
    force: FloatArray = np.column_stack([0.4 * np.sin(phase / 2.0), 0.5 * np.cos(phase), np.sin(phase)]) * size_mps2
    force += [0.0, 0.0, 9.81] + 0.05 * rng.standard_normal(force.shape)
    return inertial_batch(0, {"accelerometer": AxisSamples(time_s, held.inv().apply(force))})


@pytest.mark.parametrize("held", TILTS)
def test_a_phone_is_still_when_held_and_moves_when_carried(held: Rotation) -> None:
    still = advance_shaking(ShakingState(), shaken(5.0, 0.0, held))
    assert still.still
    walking = advance_shaking(still, shaken(2.0, 2.5, held, 5.0))
    assert not walking.still
    assert advance_shaking(walking, shaken(8.0, 0.0, held, 7.0)).still


def test_a_phone_nothing_is_known_of_is_not_called_still() -> None:
    assert not ShakingState().still
    assert not advance_shaking(ShakingState(), shaken(0.1, 0.0, TILTS[0])).still


def test_after_a_gap_stillness_has_to_show_again() -> None:
    still = advance_shaking(ShakingState(), shaken(5.0, 0.0, TILTS[0]))
    assert not advance_shaking(still, shaken(0.1, 0.0, TILTS[0], 30.0)).still


def test_where_a_walk_is_cut_makes_no_difference() -> None:
    batch = shaken(6.0, 1.0, TILTS[1])
    whole, cut = advance_shaking(ShakingState(), batch), ShakingState()
    for until_s in (0.3, 2.0, 2.01, None):
        cut = advance_shaking(cut, batch, until_s)
    assert np.array_equal(whole.values, cut.values)


def test_a_push_to_the_side_alone_is_movement() -> None:
    time_s = np.arange(0.0, 6.0, 1.0 / RATE_HZ)
    force = np.column_stack([np.zeros_like(time_s), 1.5 * np.sin(2.0 * np.pi * time_s), np.full_like(time_s, 9.81)])
    batch = inertial_batch(0, {"accelerometer": AxisSamples(time_s, force)})
    assert not advance_shaking(ShakingState(), batch).still
