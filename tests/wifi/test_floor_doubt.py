"""Votes for a floor are doubted as much as the survey's own walks, left out of the map, say."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import calibrated_map
from app.wifi.floor_decision import FloorSettings
from app.wifi.floor_doubt import SECTION, TRIED, floor_settings, learnt_doubt
from app.wifi.left_out import left_out_scans
from app.wifi.radio_map import build_radio_map
from app.wifi.radio_map_codec import decode_radio_map, encode_radio_map
from tests.wifi.surveys import heard_at


def survey(floors_alike: bool, walks: int = 8, seed: int = 5) -> list[Fingerprint]:
    """Walks on two floors; where floors are alike the upper one hears what the lower one hears."""
    rng = np.random.default_rng(seed)
    found = []
    for walk in range(walks):
        for number, floor in enumerate(("F1", "F2")):
            for x_m in np.arange(0.0, 40.0, 2.0):
                scan = heard_at(float(x_m), 0 if floors_alike else number, rng, 3.0)
                found.append(
                    Fingerprint(floor, float(x_m), 1.0, float(x_m), f"{floor}-{walk}", scan.bssid, scan.rssi_dbm)
                )
    return found


def doubt_of(found: list[Fingerprint]) -> FloorSettings:
    return learnt_doubt(found, left_out_scans(found), ["F1", "F2"])


def test_where_floors_sound_apart_votes_count_as_usual() -> None:
    assert doubt_of(survey(floors_alike=False)) == TRIED[0] == floor_settings(build_radio_map([]))


def test_where_floors_sound_alike_votes_are_doubted_as_much_as_can_be() -> None:
    assert doubt_of(survey(floors_alike=True)) == TRIED[-1]


def test_the_order_of_the_survey_does_not_matter() -> None:
    found = survey(floors_alike=True, walks=4)
    assert doubt_of(found) == doubt_of(found[::-1])


def test_a_survey_of_one_floor_or_of_one_walk_leaves_the_usual_doubt() -> None:
    one_floor = [one for one in survey(floors_alike=True, walks=3) if one.floor == "F1"]
    assert learnt_doubt(one_floor, left_out_scans(one_floor), ["F1"]) == TRIED[0]
    one_walk = [replace(one, walk="only") for one in one_floor]
    assert learnt_doubt(one_walk, left_out_scans(one_walk), ["F1", "F2"]) == TRIED[0]


def test_where_walks_leave_parts_of_a_floor_to_the_other_unlike_scans_are_not_to_vote() -> None:
    """Each place of the upper floor was walked once, so that whoever is left out was where nobody surveyed."""
    lower = [one for one in survey(floors_alike=False) if one.floor == "F1"]
    upper = [
        one
        for one in survey(floors_alike=False, walks=2)
        if one.floor == "F2" and (one.x_m >= 20.0) == (one.walk == "F2-1")
    ]
    learnt = doubt_of([*lower, *upper])
    assert learnt.unlike < math.inf
    assert learnt in TRIED


def test_what_was_learnt_is_stored_with_the_map() -> None:
    published = calibrated_map(survey(floors_alike=True))
    assert floor_settings(decode_radio_map(encode_radio_map(published))) == TRIED[-1]


def test_what_an_earlier_release_stored_is_still_read() -> None:
    earlier = replace(build_radio_map([]), sections={SECTION: np.array([0.3])})
    assert floor_settings(earlier) == FloorSettings(doubt=0.3)


def test_a_floor_of_one_walk_and_one_that_only_beacons_are_heard_on_are_published_with_the_others() -> None:
    found = survey(floors_alike=False, walks=4)
    once = [replace(one, floor="F1a", walk="only") for one in found if one.floor == "F2" and one.walk == "F2-0"]
    key = np.array([1 << 60])
    beacons = [replace(one, floor="F9", bssid=key, rssi_dbm=np.array([-60.0])) for one in found[:20]]
    radio_map = calibrated_map([*found, *once, *beacons])
    assert radio_map.floors == ("F1", "F1a", "F2", "F9")
    placed = left_out_scans([*found, *once], floors=radio_map.floors)
    assert {len(match.floor_probability) for match in placed.match} == {4}
    assert {radio_map.floors[match.floor] for match in placed.match} == {"F1", "F2"}
    on_f1 = np.array([radio_map.floors[match.floor] == "F1" for match in placed.match])
    assert placed.floor_right[on_f1].all()
