"""What the sensors of a phone feel that is not looked at: in a trouser pocket, at the ear, in a swinging hand.

A leg or an arm is a pendulum that swings once a stride, with the phone at its lower end; the head only goes along with
the body. The phone lies in its place at any angle. Sizes are those of gait textbooks: thighs swing 15 to 28 degrees to
either side and heels strike once a stride, arms 10 to 40 degrees with the hand 0.5 to 0.7 m below the shoulder.
Only the hand in front is fitted to recordings, the mall walks of folds 1-4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from app.estimation.arrays import FloatArray
from app.observations import Carrying
from app.simulation.imu import InertialRecord, body_motion_mps2, held, sensed, wander
from app.simulation.random_field import RandomField
from app.simulation.walker import Walk


@dataclass(frozen=True, slots=True)
class Bearing:
    """How somebody carries themselves.

    thigh_rad, thigh_m : swing to either side, and the phone's distance below the hip.  arm_rad, arm_m : the same of an
    arm, below the shoulder.  elbow : share of the arm's swing that comes again at twice the frequency.  strike_mps2 :
    of the heel, at the thigh.  head : share of the body's movement that reaches the head.
    hand : share of its movement to the sides that reaches a hand in front.
    """

    thigh_rad: float
    thigh_m: float
    arm_rad: float
    arm_m: float
    elbow: float
    strike_mps2: float
    head: float
    hand: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> Bearing:
        """Somebody."""
        return cls(
            thigh_rad=float(np.radians(rng.uniform(15.0, 28.0))),
            thigh_m=float(rng.uniform(0.1, 0.4)),
            arm_rad=float(np.radians(rng.uniform(10.0, 40.0))),
            arm_m=float(rng.uniform(0.5, 0.7)),
            elbow=float(rng.uniform(0.0, 0.25)),
            strike_mps2=float(rng.uniform(8.0, 25.0)),
            head=float(rng.uniform(0.6, 1.0)),
            hand=float(rng.uniform(0.3, 1.0)),
        )


def feel_carried(
    walk: Walk, position: Carrying, bearing: Bearing, disturbance: RandomField, rng: np.random.Generator
) -> InertialRecord:
    """The sensors' samples along a walk of a phone that is carried so, one each at every time of the walk.

    Raises
    ------
    KeyError : of no position in CLASSES (app/pdr/carrying_position.py).
    """
    if position is Carrying.HANDHELD:
        calm = np.array([bearing.hand, bearing.hand, 1.0])
        return sensed(walk, held(walk, rng), calm * body_motion_mps2(walk, rng), disturbance, rng)
    carry = {Carrying.POCKET: _in_pocket, Carrying.CALL: _at_ear, Carrying.SWINGING: _in_swinging_hand}[position]
    limb, local_mps2 = carry(walk, bearing, rng)
    heading = Rotation.from_rotvec(np.outer(-walk.heading_rad, [0.0, 0.0, 1.0]))
    return sensed(walk, heading * limb, heading.apply(local_mps2), disturbance, rng)


def _body(walk: Walk, rng: np.random.Generator) -> FloatArray:
    """Acceleration (n, 3) of the trunk to the walker's right, ahead and up.

    The trunk is pushed ahead while it is lifted; what a phone in the hand shows has another phase.
    """
    to_walker = Rotation.from_rotvec(np.outer(walk.heading_rad, [0.0, 0.0, 1.0]))
    body = to_walker.apply(body_motion_mps2(walk, rng))
    body[:, 1] = -body[:, 1]
    return np.asarray(body, dtype=np.float64)


def _pendulum(
    rate_hz: float, swing_rad: FloatArray, lever_m: float, rng: np.random.Generator
) -> tuple[Rotation, FloatArray]:
    """Attitude of a phone anyhow at the end of a limb, and the acceleration (n, 3) that the swing adds, as in _body."""
    limb = Rotation.from_euler("x", swing_rad[:, np.newaxis])
    slip = np.column_stack([wander(rng, len(swing_rad), 3.0 * rate_hz, np.radians(3.0)) for _ in range(3)])
    place_m = limb.apply([0.0, 0.0, -lever_m])
    added = np.gradient(np.gradient(place_m, axis=0), axis=0) * rate_hz**2
    return limb * Rotation.from_rotvec(slip) * Rotation.random(rng=rng), np.asarray(added, dtype=np.float64)


def _pace(walk: Walk) -> FloatArray:
    """(n,) how widely limbs swing: 0 of who stands, 1 of a usual walk."""
    return np.asarray(gaussian_filter1d(np.clip(walk.speed_mps / 1.2, 0.0, 1.3), 0.2 * walk.rate_hz), dtype=np.float64)


def _in_pocket(walk: Walk, bearing: Bearing, rng: np.random.Generator) -> tuple[Rotation, FloatArray]:
    stride = np.pi * (walk.step_phase + rng.integers(2)) + rng.normal(0.2, 0.15)
    pace = _pace(walk)
    swing = bearing.thigh_rad * pace * (np.cos(stride) + 0.25 * np.cos(2.0 * stride + rng.normal(0.8, 0.3)))
    limb, added = _pendulum(walk.rate_hz, swing + rng.normal(0.1, 0.1), bearing.thigh_m, rng)
    # the own heel strikes at the end of the swing, the other one's is felt through the hip
    for phase, share in ((0.0, 1.0), (np.pi, rng.uniform(0.2, 0.5))):
        since = np.mod(stride - phase, 2.0 * np.pi) / (2.0 * np.pi) / np.maximum(walk.person.step_hz / 2.0, 0.5)
        ring = np.exp(-since / 0.04) * np.sin(2.0 * np.pi * rng.uniform(9.0, 14.0) * since)
        shock = share * bearing.strike_mps2 * pace * ring
        added += np.outer(shock, [rng.normal(0.0, 0.2), -0.6, 1.0])
    return limb, _body(walk, rng) + added


def _in_swinging_hand(walk: Walk, bearing: Bearing, rng: np.random.Generator) -> tuple[Rotation, FloatArray]:
    stride = np.pi * (walk.step_phase + rng.integers(2)) + rng.normal(0.0, 0.3)
    swing = bearing.arm_rad * _pace(walk)
    swing = swing * (np.cos(stride) + bearing.elbow * np.cos(2.0 * stride + rng.uniform(0.0, 6.0)))
    swing = swing * np.exp(wander(rng, len(swing), 3.0 * walk.rate_hz, 0.12))
    limb, added = _pendulum(walk.rate_hz, swing + rng.normal(0.15, 0.1), bearing.arm_m, rng)
    return limb, rng.uniform(0.6, 0.9) * _body(walk, rng) + added


def _at_ear(walk: Walk, bearing: Bearing, rng: np.random.Generator) -> tuple[Rotation, FloatArray]:
    count = len(walk.time_s)
    nod = [wander(rng, count, 2.0 * walk.rate_hz, np.radians(2.0)) for _ in range(3)]
    nod[0] = nod[0] + np.radians(rng.uniform(0.5, 2.0)) * np.sin(2.0 * np.pi * walk.step_phase + rng.uniform(0.0, 6.0))
    # the head is kept steady: what the spine lets through is the slow part
    head = gaussian_filter1d(_body(walk, rng), 0.03 * walk.rate_hz, axis=0) * [0.6, 0.6, bearing.head]
    # the screen at the cheek, the top edge up and back at the ear
    rise = np.radians(rng.uniform(35.0, 75.0))
    top, screen = np.array([0.0, -np.cos(rise), np.sin(rise)]), np.array([rng.choice([-1.0, 1.0]), 0.0, 0.0])
    held_so = Rotation.from_matrix(np.column_stack([np.cross(top, screen), top, screen]))
    tilt = Rotation.from_rotvec(rng.normal(0.0, np.radians(10.0), 3))
    return Rotation.from_rotvec(np.column_stack(nod)) * tilt * held_so, head
