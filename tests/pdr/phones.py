"""Phones for the tests: synthetic ones that are walked, turned, shaken or left alone, and recorded ones."""

from __future__ import annotations

import csv
import lzma
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.observations import AxisSamples, Batch
from app.pdr.tracker import PdrOutput, PdrState, advance_pdr, initial_pdr_state

START_S = 1_574_559_781.0
GRAVITY = np.array([0.0, 0.0, 9.81])
FIELD_UT = np.array([0.0, 28.0, -38.0])
STREAMS = ("accelerometer", "gyroscope", "magnetometer", "rotation_vector")


@dataclass(frozen=True)
class Phone:
    """All four streams of one phone."""

    accelerometer: AxisSamples
    gyroscope: AxisSamples
    magnetometer: AxisSamples
    rotation_vector: AxisSamples

    def batch(self, *streams: str) -> Batch:
        """Everything at once, of the named streams."""
        return inertial_batch(0, {name: getattr(self, name) for name in streams or STREAMS})

    def batches(self, cuts_s: Iterable[float], *streams: str) -> list[Batch]:
        """The same cut at the given times; a sample at a cut belongs to the batch before."""
        batches, begin = [], -np.inf
        for sequence, end in enumerate([*sorted(cuts_s), np.inf]):
            cut: dict[str, AxisSamples] = {}
            for name in streams or STREAMS:
                samples: AxisSamples = getattr(self, name)
                keep = (samples.time_s > begin) & (samples.time_s <= end)
                cut[name] = AxisSamples(samples.time_s[keep], samples.values[keep])
            batches.append(inertial_batch(sequence, cut))
            begin = end
        return batches


def inertial_batch(sequence: int, streams: dict[str, AxisSamples]) -> Batch:
    """A batch of the given inertial streams."""
    return replace(Batch(sequence, None), **streams)  # type: ignore[arg-type]


def run(*batches: Batch, state: PdrState | None = None) -> list[PdrOutput]:
    """The answers to a series of batches."""
    outputs = []
    state = state or initial_pdr_state()
    for batch in batches:
        state, output = advance_pdr(state, batch)
        outputs.append(output)
    return outputs


def sensed(time_s: FloatArray, attitude: Rotation, force_mps2: FloatArray, seed: int = 0) -> Phone:
    """What a phone of this attitude (device to east-north-up) and acceleration senses, with some noise."""
    rng = np.random.default_rng(seed)
    turned = (attitude[:-1].inv() * attitude[1:]).as_rotvec() / np.diff(time_s)[:, None]
    rate = np.vstack([turned[:1], turned]) + rng.normal(0.0, 0.005, force_mps2.shape)
    force = attitude.inv().apply(force_mps2 + GRAVITY) + rng.normal(0.0, 0.05, force_mps2.shape)
    field = attitude.inv().apply(np.tile(FIELD_UT, (len(time_s), 1))) + rng.normal(0.0, 0.3, force_mps2.shape)
    vector = attitude.as_quat(canonical=True)[:, :3]
    streams = (force, rate, field, vector)
    return Phone(*(AxisSamples(time_s, np.ascontiguousarray(values, dtype=np.float64)) for values in streams))


def walked(
    heading_rad: float = 0.7,
    seconds: float = 30.0,
    rate_hz: float = 50.0,
    steps_per_s: float = 1.8,
    turn_rad_per_s: float = 0.0,
    jitter: float = 0.0,
    seed: int = 0,
) -> Phone:
    """Held in front of a walker, between 2 s of standing before and after; it nods a little with every step."""
    rng = np.random.default_rng(seed)
    elapsed = np.arange(int((seconds + 4.0) * rate_hz)) / rate_hz
    elapsed = np.sort(elapsed + jitter / rate_hz * rng.uniform(-0.5, 0.5, len(elapsed)))
    walking = (elapsed >= 2.0) & (elapsed < seconds + 2.0)
    phase = 2.0 * np.pi * steps_per_s * (elapsed - 2.0)
    up = walking * (3.0 * np.sin(phase) + 0.8 * np.sin(2.0 * phase + 0.5))
    heading = heading_rad + turn_rad_per_s * np.clip(elapsed - 2.0, 0.0, seconds)
    pitch = 0.4 + 0.06 * walking * np.sin(phase + 1.0)
    attitude = Rotation.from_euler("ZX", np.column_stack([-heading, pitch]))
    force = np.column_stack([np.zeros_like(up), np.zeros_like(up), up])
    return sensed(START_S + elapsed, attitude, force, seed)


def recorded_steps(folder: Path) -> tuple[AxisSamples, FloatArray, FloatArray]:
    """A recording of the Oxford set: the accelerometer, and the strikes of the left and of the right foot (s)."""
    with lzma.open(folder / "accelerometer.csv.xz", "rt") as file:
        rows = np.array([[float(row[0]), *map(float, row[2:5])] for row in csv.reader(file)])
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    with lzma.open(folder / "stepcounter.csv.xz", "rt") as file:
        feet = np.array([[float(cell) for cell in row] for row in csv.reader(file)])
    left, right = (feet[1:, 0][np.diff(feet[:, column]) > 0] / 1e9 for column in (1, 2))
    return AxisSamples(rows[:, 0] / 1e9, np.ascontiguousarray(rows[:, 1:])), left, right


def strides(strikes_s: FloatArray) -> int:
    """How often one foot fell: contacts that chatter count once, ones the switch missed are filled in."""
    stride = np.median(np.diff(strikes_s))
    kept = [strikes_s[0]]
    for strike in strikes_s[1:]:
        if strike - kept[-1] > 0.6 * stride:
            kept.append(strike)
    return 1 + int(np.round(np.diff(kept) / stride).sum())
