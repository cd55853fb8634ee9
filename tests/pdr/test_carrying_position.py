"""Where the phone is carried: features that no turn of the phone changes, a forest that is read right, and what it
recognises in recordings that it was not made from."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sklearn.ensemble import RandomForestClassifier

from app.commands.train_carrying import model_bytes
from app.estimation.arrays import FloatArray
from app.observations import AxisSamples, Batch, Carrying
from app.pdr.carried_phone import CarriedPhone, advance_carried, windows_of
from app.pdr.carried_state import CELLS, NORM, TIME
from app.pdr.carrying_position import (
    CLASSES,
    FEATURES,
    Forest,
    Recognised,
    carrying_forest,
    says_something,
    window_features,
)
from app.pdr.quaternion_ukf import QuaternionNoise
from app.survey.trace import read_trace
from tests.open_data import open_data
from tests.pdr.phones import START_S, Phone, inertial_batch, recorded_steps, sensed, walked

NOISE = QuaternionNoise()
OXFORD = {
    "Samsung_Dario_Hard_InHand_1": Carrying.HANDHELD,
    "Samsung_Dario_Hard_FrontPocket_1": Carrying.POCKET,
    "Samsung_Dario_Hard_BackPocket_1": Carrying.POCKET,
    "Pixel_Jamie_Hard_SwingingArm_1": Carrying.SWINGING,
}


def features_of(phone: Phone) -> FloatArray:
    windows = windows_of(phone.batch("accelerometer", "gyroscope", "magnetometer"), NOISE)
    return np.array([window_features(cells) for cells in windows if says_something(cells)])


def test_there_are_fifteen_features() -> None:
    assert len(FEATURES) == len(set(FEATURES)) == 15
    assert features_of(walked()).shape[1] == 15


@pytest.mark.parametrize("seed", range(3))
def test_how_the_phone_lies_in_its_place_changes_no_feature(seed: int) -> None:
    phone = walked(turn_rad_per_s=0.1)
    turn = Rotation.random(rng=np.random.default_rng(seed))
    turned = Phone(
        *(
            AxisSamples(stream.time_s, np.ascontiguousarray(turn.apply(stream.values)))
            for stream in (phone.accelerometer, phone.gyroscope, phone.magnetometer, phone.rotation_vector)
        )
    )
    plain, other = features_of(phone), features_of(turned)
    assert plain.shape == other.shape
    # the first windows still level themselves, from another start
    assert np.abs(plain[3:] - other[3:]).max() < 0.1


def test_windows_last_two_seconds_and_overlap_by_half() -> None:
    ends = []
    for cells in windows_of(walked().batch("accelerometer", "gyroscope"), NOISE):
        assert np.ptp(cells[:, TIME]) < 2.0
        ends.append(math.ceil(cells[-1, TIME]))
    assert all(later - earlier == 1 for earlier, later in pairwise(ends))
    assert len(ends) >= 30


def test_the_exported_trees_answer_as_the_forest_that_they_come_from() -> None:
    rng = np.random.default_rng(3)
    position = rng.integers(0, 4, 600)
    features = rng.normal(size=(600, 15)) + position[:, None] * rng.normal(size=15)
    forest = RandomForestClassifier(8, max_depth=6, random_state=0).fit(features, position)
    arrays = read_arrays(model_bytes(forest))
    ours = Forest(*(arrays[name] for name in ("root", "feature", "threshold", "left", "right", "share")))
    new = rng.normal(size=(200, 15)) * 3.0
    found = np.array([ours.probabilities(row) for row in new])
    assert np.abs(found - forest.predict_proba(new)).max() < 1e-6


def read_arrays(content: bytes) -> dict[str, Any]:
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def test_the_model_is_small() -> None:
    forest = carrying_forest()
    assert len(forest.root) == 30
    assert sum(one.nbytes for one in (forest.feature, forest.threshold, forest.left, forest.right, forest.share)) < 4e5


def advanced(recording: Batch) -> Iterator[CarriedPhone]:
    """The phone after every second of a recording."""
    phone, times = CarriedPhone(), recording.accelerometer.time_s
    for end in np.arange(times[0] + 1.0, times[-1], 1.0):
        phone = advance_carried(phone, recording, NOISE, float(end))
        yield phone


def recognised(force: AxisSamples) -> dict[Carrying, float]:
    """Share of the windows of movement by the position that was known at their ends."""
    found, newest = [], -math.inf
    for phone in advanced(inertial_batch(0, {"accelerometer": force})):
        if phone.recognised.answers[-1, 0] > newest:
            newest = float(phone.recognised.answers[-1, 0])
            found.append(phone.recognised.at(newest))
    return {one: found.count(one) / len(found) for one in CLASSES}


@pytest.mark.parametrize(
    ("folder", "recall"),
    [
        ("Samsung_Dario_Hard_InHand_1", 0.81),
        ("Samsung_Dario_Hard_FrontPocket_1", 1.0),
        ("Samsung_Dario_Hard_BackPocket_1", 0.72),
        ("Pixel_Jamie_Hard_SwingingArm_1", 0.13),
    ],
)
def test_recall_in_the_recordings_is_what_the_page_says(folder: str, recall: float) -> None:
    """One recording each, without gyroscope. There is none of a call: that class is untested."""
    force, _, _ = recorded_steps(open_data("oxford_steps", folder))
    assert recognised(force)[OXFORD[folder]] == pytest.approx(recall, abs=0.05)


def test_the_phones_of_the_mall_are_recognised_as_looked_at() -> None:
    """Surveyors hold theirs in front. These walks shaped the simulated hand, those of the Oxford set did not."""
    known = []
    folder = open_data("mall", "F1", "path_data_files")
    for path in sorted(folder.iterdir())[:30:3]:
        trace = read_trace(path.read_bytes(), path.name)
        streams = {name: getattr(trace, name) for name in ("accelerometer", "gyroscope", "magnetometer")}
        phones = [phone.recognised for phone in advanced(inertial_batch(0, streams))]
        known += [phone.at(math.inf) for phone in phones if math.isfinite(phone.answers[-1, 0])]
    assert known.count(Carrying.HANDHELD) > 0.9 * len(known)


def test_a_phone_on_a_table_is_carried_nowhere() -> None:
    time_s = START_S + np.arange(1500) / 50.0
    lying = sensed(time_s, Rotation.identity(1500), np.zeros((1500, 3)))
    phone = advance_carried(CarriedPhone(), lying.batch(), NOISE)
    assert phone.recognised.at(math.inf) is Carrying.UNKNOWN


def test_what_is_known_later_does_not_change_what_was_known_before() -> None:
    answers = np.tile([-math.inf, 0.25, 0.25, 0.25, 0.25], (6, 1))
    answers[-2:] = [[10.0, 0.9, 0.1, 0.0, 0.0], [11.0, 0.1, 0.9, 0.0, 0.0]]
    known = Recognised(12.0, answers)
    assert known.at(9.9) is Carrying.UNKNOWN
    assert known.at(10.5) is Carrying.HANDHELD
    assert known.at(11.0) is Carrying.POCKET


@pytest.mark.parametrize("seconds", [0.1, 0.37, 7.0])
def test_how_the_samples_are_cut_changes_nothing(seconds: float) -> None:
    phone = walked(turn_rad_per_s=0.05, jitter=0.3)
    whole = advance_carried(CarriedPhone(), phone.batch(), NOISE)
    cut = CarriedPhone()
    for batch in phone.batches(START_S + np.arange(seconds, 34.0, seconds)):
        cut = advance_carried(cut, batch, NOISE)
    assert np.array_equal(whole.motion.cells, cut.motion.cells)
    assert np.array_equal(whole.motion.covariance, cut.motion.covariance)
    assert np.array_equal(whole.recognised.answers, cut.recognised.answers)
    assert whole.motion.cells_between(-math.inf, math.inf).shape == (CELLS, 8)
    assert (whole.motion.cells[:, NORM] > 0.0).all()


def test_a_batch_without_samples_is_no_news() -> None:
    phone = advance_carried(CarriedPhone(), walked().batch(), NOISE)
    again = advance_carried(phone, Batch(1, None), NOISE)
    assert again.motion is phone.motion and again.recognised.next_s == phone.recognised.next_s
