"""The trust chain relies on steps while they are trusted and on WiFi when they are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.evaluation.alone import ALONE
from app.fusion.chain import Chain, begun, fused
from app.fusion.interface import Method, SessionStart
from app.fusion.trust_chain import TRUST_CHAIN, TrustChainState, start, trust_chain
from app.fusion.trust_chain_settings import TrustChainSettings
from app.fusion.trust_state import AT_START, Trust
from app.observations import Batch
from tests.fusion.walks import errors_m, lying, places_m, run, site, walked, without

WALK = walked(5, length_m=150.0)
OURS = TrustChainSettings()


def chains(batches: tuple[Batch, ...] | list[Batch], method: Method = TRUST_CHAIN) -> list[TrustChainState]:
    state, found = start(SessionStart()), []
    for batch in batches:
        state, _ = method.advance(state, batch, site())
        found.append(state)
    return found


def test_a_session_begins_unlocked_with_the_mistrust_of_one_fix() -> None:
    first = next(state for state in chains(WALK.batches) if state.chain is not None)
    assert first.chain is not None
    assert first.chain.trust is Trust.UNLOCKED and first.chain.mistrust == AT_START


def test_all_three_states_occur_on_a_walk() -> None:
    seen = {state.chain.trust for seed in (1, 2, 4, 5) for state in chains(walked(seed).batches) if state.chain}
    assert seen == set(Trust)


def test_a_trusted_fix_weighs_by_the_mistrust_before_it_and_ends_it() -> None:
    chain = replace(begun(np.array([0.0, 0.0]), 5.0, 0.0), mistrust=0.25)
    after = fused(chain, np.array([1.0, 0.0]), 0.2, True, Trust.TRUSTED_LOCKED, OURS)
    assert after.at_m.tolist() == [0.2, 0.0] and after.last_m.tolist() == [0.2, 0.0]
    assert after.mistrust == 0.0 and after.sigma_m == OURS.trusted_sigma_m


def test_between_fixes_the_mistrust_grows_with_the_steps() -> None:
    states = chains(WALK.batches)
    grown = 0
    for batch, before, after in zip(WALK.batches[1:], states, states[1:], strict=False):
        if before.chain is None or after.chain is None or batch.wifi or after.step_count == before.step_count:
            continue
        if before.chain.mistrust < OURS.most_mistrust:
            assert after.chain.mistrust > before.chain.mistrust
            grown += 1
    assert grown > 5


def test_a_phone_whose_steps_lead_nowhere_known_is_unlocked() -> None:
    lost = [without(batch, "rotation_vector", "magnetometer", "gyroscope") for batch in WALK.batches]
    states, stepped = chains(lost), 0
    for batch, before, after in zip(lost[1:], states, states[1:], strict=False):
        if after.chain is not None and not batch.wifi and after.step_count > before.step_count:
            assert after.chain.heading_rad is None and after.chain.mistrust >= AT_START
            stepped += 1
    assert stepped > 20


def test_a_phone_without_compass_finds_north_and_is_carried_by_its_steps_again() -> None:
    found: list[Chain] = []
    for seed in (1, 2, 4, 5):
        batches = [without(batch, "rotation_vector", "magnetometer") for batch in walked(seed, 150.0).batches]
        found += [state.chain for state in chains(batches) if state.chain is not None]
    assert found[0].heading_rad is None
    assert sum(chain.heading_rad is not None for chain in found) > 100


def test_a_still_phone_hears_weaker_access_points_than_a_moving_one() -> None:
    assert chains(lying().batches)[-1].shaking.still
    assert not any(state.shaking.still for state in chains(WALK.batches)[10:30])


def test_fused_is_better_than_its_wifi_alone_and_than_the_cross_assistive_algorithm() -> None:
    errors: dict[str, list[float]] = {}
    rows = {name: ALONE[name] for name in ("trust_chain_wifi_alone", "trust_chain_cross_assistive")}
    for name, method in {**rows, "trust_chain": TRUST_CHAIN}.items():
        errors[name] = []
        for seed in (1, 2, 4, 5, 6, 7):
            walk = walked(seed, length_m=150.0)
            errors[name] += errors_m(walk, run(method, walk.batches)).tolist()
    mean = {name: np.mean(found) for name, found in errors.items()}
    assert mean["trust_chain"] < min(mean["trust_chain_wifi_alone"], mean["trust_chain_cross_assistive"])


def test_wifi_alone_stays_where_its_last_fix_was() -> None:
    alone = ALONE["trust_chain_wifi_alone"]
    places = places_m(run(alone, WALK.batches))
    moved = np.count_nonzero(np.any(np.diff(places, axis=0) != 0.0, axis=1))
    assert moved <= sum(bool(batch.wifi) for batch in WALK.batches)


def test_a_wider_trusted_area_trusts_more_fixes() -> None:
    wide = trust_chain("wide", replace(OURS, distance_m=6.0, bearing_rad=2.0))

    def trusted(method: Method) -> int:
        states = chains(WALK.batches, method)
        return sum(state.chain is not None and state.chain.trust is Trust.TRUSTED_LOCKED for state in states)

    assert trusted(wide) > trusted(TRUST_CHAIN)
