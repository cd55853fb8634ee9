"""The faults of the campaign: what an attacker, a broken phone or a changed building does to a recorded walk.

Each is a pure function of the walk, the survey around it and seeded dice. What the phone recorded changes, the truth
does not. Faults of the building and of the phone last the whole walk, those that happen begin in its middle.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from app.evaluation.faulty_walk import Injector
from app.evaluation.phone_faults import (
    clock_jump,
    gyroscope_biased,
    gyroscope_stuck,
    held_across,
    magnet,
    without_rotation_vector,
    wrong_start,
)
from app.evaluation.radio_faults import (
    attenuated,
    duplicated,
    moved,
    repeated,
    replay,
    rogue,
    silent,
    spoofed,
    stale,
    swapped,
    thinned,
    vanished,
)

FAULTS: Mapping[str, Injector] = {
    "replay": replay,
    "rogue": rogue,
    "moved": moved,
    "swapped": swapped,
    "spoofed": spoofed,
    "duplicated": duplicated,
    "vanished": vanished,
    "offset": attenuated,
    "half_gone": thinned,
    "stale_map": stale,
    "silence_20": partial(silent, seconds=20.0),
    "silence_60": partial(silent, seconds=60.0),
    "duplicates": repeated,
    "clock_jump": clock_jump,
    "wrong_start": wrong_start,
    "held_across": held_across,
    "no_rotation": without_rotation_vector,
    "magnet": magnet,
    "gyro_stuck": gyroscope_stuck,
    "gyro_biased": gyroscope_biased,
}
"""The campaign, in the order of its table."""
