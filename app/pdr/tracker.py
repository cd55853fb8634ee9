"""From a batch of inertial samples to steps: the one entry that the fusion methods use."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.observations import AxisSamples, Batch, Carrying, Motion, Step
from app.pdr import attitude, rhythm, sample_order, step_detection
from app.pdr.attitude_state import AttitudeState
from app.pdr.push import felt_after, kept_of, push_rad
from app.pdr.step_detection import StepState
from app.pdr.step_length import weinberg_length_m


@dataclass(frozen=True, slots=True, eq=False)
class PdrState:
    """Everything dead reckoning remembers between batches. felt : as of felt_after."""

    attitude: AttitudeState = field(default_factory=AttitudeState)
    steps: StepState = field(default_factory=StepState)
    felt: FloatArray = field(default_factory=lambda: np.empty((0, 4)))


@dataclass(frozen=True, slots=True, eq=False)
class PdrOutput:
    """What a batch's inertial samples say.

    steps : in time order. The first few of a walk come about 1.5 s late, once their rhythm is certain, later ones
    within 0.4 s of the foot's strike; each carries its true time.
    motion, carrying : at the end.
    pending_fraction : share in [0, 1] of the next step's duration that has passed since the last; 0 when not walking.
    still_since_s : since when the phone has been motionless, or None.
    inertial_until_s : time of the newest accelerometer sample, or None if there never was one: no steps can be told.
    """

    steps: tuple[Step, ...]
    motion: Motion
    carrying: Carrying
    pending_fraction: float
    still_since_s: float | None
    inertial_until_s: float | None


def initial_pdr_state() -> PdrState:
    """The state of a phone that has not reported yet."""
    return PdrState()


def advance_pdr(state: PdrState, batch: Batch, until_s: float | None = None) -> tuple[PdrState, PdrOutput]:
    """Process a batch's inertial samples that are newer than those already processed.

    Parameters
    ----------
    state : from initial_pdr_state() or the previous call.
    batch : its accelerometer, gyroscope, magnetometer and rotation vector are used, each may be empty.
    until_s : leave samples later than this for a later call with the same batch.

    Returns
    -------
    The next state, and the steps. Samples that arrive out of order with their own stream are skipped.

    Notes
    -----
    Where a walk is cut into batches has no influence, as long as all streams are cut at the same time.
    Without a gyroscope `heading_change_rad` of a step is the change of the heading; without a magnetometer
    `magnetic_heading_rad` is NaN.
    """
    newest = state.attitude.time_s
    acc_time_s, acc = fresh_samples(batch.accelerometer, newest[sample_order.ACC], until_s)
    gyr_time_s, gyr = fresh_samples(batch.gyroscope, newest[sample_order.GYR], until_s)
    mag_time_s, mag = fresh_samples(batch.magnetometer, newest[sample_order.MAG], until_s)
    rot_time_s, rot = fresh_samples(batch.rotation_vector, newest[sample_order.ROT], until_s)
    if not (len(acc_time_s) or len(gyr_time_s) or len(mag_time_s) or len(rot_time_s)):
        return state, _output(state, ())
    attitude_arrays, step_arrays = state.attitude.arrays(), state.steps.arrays()
    tracked, swayed = np.empty((len(acc_time_s), 7)), np.empty((len(acc_time_s), 2))
    attitude.track(attitude_arrays, acc_time_s, acc, gyr_time_s, gyr, mag_time_s, mag, rot_time_s, rot, tracked, swayed)
    felt = felt_after(state.felt, acc_time_s, tracked, swayed)
    # no more than one step in 0.3 s, nor than samples, plus those held from before
    span_s = acc_time_s[-1] - max(acc_time_s[0] - 1.0, newest[sample_order.ACC]) if len(acc_time_s) else 0.0
    found = np.empty((min(int(span_s / rhythm.SHORTEST_S), len(acc_time_s)) + 8, 7))
    count = step_detection.detect(step_arrays, acc_time_s, tracked, found)
    after = PdrState(AttitudeState(*attitude_arrays), StepState(*step_arrays), kept_of(felt))
    return after, _output(after, tuple(_step(row, felt) for row in found[:count]))


def _output(state: PdrState, steps: tuple[Step, ...]) -> PdrOutput:
    signal, walk = state.steps.signal, state.steps.walk
    until_s = float(state.attitude.time_s[sample_order.ACC])
    since_step_s = until_s - float(walk[rhythm.STEP_S]) if math.isfinite(until_s) else math.inf
    period_s = float(walk[rhythm.PERIOD])
    walking = since_step_s < rhythm.STEP_OVERDUE * period_s
    still_since_s = float(signal[step_detection.STILL_SINCE_S])
    is_still = math.isfinite(still_since_s)
    motion = Motion.STILL if is_still else Motion.WALKING if walking else Motion.UNKNOWN
    handheld = Carrying.HANDHELD if motion is Motion.WALKING else Carrying.UNKNOWN
    return PdrOutput(
        steps=steps,
        motion=motion,
        carrying=handheld,
        pending_fraction=min(since_step_s / period_s, 1.0) if walking and not is_still else 0.0,
        still_since_s=still_since_s if is_still else None,
        inertial_until_s=until_s if math.isfinite(until_s) else None,
    )


def _step(row: FloatArray, felt: FloatArray) -> Step:
    time_s, duration_s = float(row[rhythm.STEP_TIME]), float(row[rhythm.STEP_DURATION])
    return Step(
        time_s=time_s,
        duration_s=duration_s,
        length_m=weinberg_length_m(float(row[rhythm.STEP_SWING])),
        heading_rad=wrap(row[rhythm.STEP_HEADING]),
        heading_sigma_rad=math.sqrt(float(row[rhythm.STEP_VARIANCE])),
        heading_change_rad=float(row[rhythm.STEP_CHANGE]),
        magnetic_heading_rad=float(row[rhythm.STEP_COMPASS]),
        push_rad=push_rad(felt, time_s, duration_s),
    )


def fresh_samples(samples: AxisSamples, newest_s: float, until_s: float | None) -> tuple[FloatArray, FloatArray]:
    """The samples in (newest_s, until_s], as contiguous float64: one compiled signature serves all."""
    time_s = samples.time_s
    if len(time_s) == 0:
        return _NO_TIMES, _NO_VALUES
    first = int(np.searchsorted(time_s, newest_s, side="right"))
    last = len(time_s) if until_s is None else int(np.searchsorted(time_s, until_s, side="right"))
    if last <= first:
        return _NO_TIMES, _NO_VALUES
    return (
        np.ascontiguousarray(time_s[first:last], dtype=np.float64),
        np.ascontiguousarray(samples.values[first:last], dtype=np.float64),
    )


_NO_TIMES: FloatArray = np.empty(0)
_NO_VALUES: FloatArray = np.empty((0, 3))
