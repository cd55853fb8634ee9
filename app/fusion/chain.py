"""The trust chain itself: a position that steps carry from fix to fix, with how far it is trusted."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from app.estimation.angles import wrap
from app.estimation.arrays import FloatArray
from app.fusion.batch_events import Event, knows_turns
from app.fusion.heading_search import HeadingSearch, sought, walked
from app.fusion.position_ekf import LOST_SHARE
from app.fusion.state_codec import storable
from app.fusion.trust_chain_settings import TrustChainSettings
from app.fusion.trust_state import AT_START, Trust, after_fix, after_way
from app.fusion.unseen import drift_m2_per_s, is_blind
from app.observations import Step
from app.pdr.tracker import PdrOutput


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """at_m : (2,) position at the last step.  sigma_m : its standard deviation in each direction.

    last_m : (2,) position at the newest fix.  mistrust : TC.  trust : state.
    heading_rad : of the last step; None while nobody knows it.  offset_rad : from the phone's own frame to north, for a
    phone that does not know north; None while it is not known.  north : the search for it.
    stride_m, stride_s : of the last step.  time_s : up to when passing time is accounted for.
    """

    at_m: FloatArray
    sigma_m: float
    last_m: FloatArray
    time_s: float
    mistrust: float = AT_START
    trust: Trust = Trust.UNLOCKED
    heading_rad: float | None = None
    offset_rad: float | None = None
    north: HeadingSearch = field(default_factory=HeadingSearch)
    stride_m: float = 0.0
    stride_s: float = 1.0


def begun(at_m: FloatArray, sigma_m: float, time_s: float) -> Chain:
    """A chain that begins at a place known with a standard deviation in each direction."""
    return Chain(at_m, sigma_m, at_m, time_s)


def stepped(chain: Chain, step: Step, event: Event, settings: TrustChainSettings) -> Chain:
    """The chain after a step, Eq. 7 and 17. One whose heading is unknown goes nowhere and is not to be relied on."""
    turns, absolute = knows_turns(event), step.absolute
    heading_rad, north = None, chain.north
    if absolute:
        heading_rad, north = step.heading_rad, HeadingSearch()
    elif turns and chain.offset_rad is not None:
        heading_rad = wrap(step.heading_rad + chain.offset_rad)
    else:
        north = walked(north, step) if turns else HeadingSearch()
    chain = replace(
        chain,
        heading_rad=heading_rad,
        offset_rad=chain.offset_rad if turns else None,
        north=north,
        stride_m=step.length_m,
        stride_s=step.duration_s,
    )
    if heading_rad is None:
        sigma_m = math.sqrt(chain.sigma_m**2 + LOST_SHARE * step.length_m**2)
        return replace(chain, sigma_m=sigma_m, mistrust=max(chain.mistrust, AT_START))
    move_m = step.length_m * np.array([math.sin(heading_rad), math.cos(heading_rad)])
    return replace(
        chain,
        at_m=chain.at_m + move_m,
        sigma_m=chain.sigma_m + settings.step_sigma * step.length_m,
        mistrust=after_way(chain.mistrust, step.length_m, settings),
    )


def aged(chain: Chain, until_s: float, moved: PdrOutput) -> Chain:
    """The chain after time has passed that no step accounts for."""
    seconds = until_s - chain.time_s
    if seconds <= 0.0:
        return chain
    mistrust = max(chain.mistrust, AT_START) if is_blind(until_s, moved) else chain.mistrust
    sigma_m = math.sqrt(chain.sigma_m**2 + drift_m2_per_s(until_s, moved) * seconds)
    return replace(chain, sigma_m=sigma_m, mistrust=mistrust, time_s=until_s)


def fused(
    chain: Chain, apart_m: FloatArray, weight: float, trusted: bool, trust: Trust, settings: TrustChainSettings
) -> Chain:
    """The chain after a fix, Eq. 16 and 18.

    Parameters
    ----------
    apart_m : (2,) fix minus where the steps lead.  weight : of the fix, in [0, 1].

    Notes
    -----
    Errors of the steps since a fix and of the next fix have the map's error in common, so their standard deviations
    are averaged, not their variances. That a fix is trusted says more than its weight.
    """
    at_m = chain.at_m + weight * apart_m
    sigma_m = (1.0 - weight) * chain.sigma_m + weight * settings.fix_sigma_m
    sigma_m = min(sigma_m, settings.trusted_sigma_m) if trusted else sigma_m
    mistrust = after_fix(chain.mistrust, trusted, settings)
    return replace(chain, at_m=at_m, sigma_m=sigma_m, last_m=at_m, mistrust=mistrust, trust=trust)


def north_found(chain: Chain) -> Chain:
    """The chain with north where fixes and steps have given it away."""
    if chain.heading_rad is not None or chain.offset_rad is not None:
        return chain
    north, heading = sought(chain.north, chain.at_m, chain.sigma_m)
    if heading is None:
        return replace(chain, north=north)
    return replace(chain, offset_rad=wrap(heading[0] - north.heading_rad), north=HeadingSearch())


def ahead_m(chain: Chain, moved: PdrOutput) -> FloatArray:
    """(2,) from the last step to where the step under way has led."""
    if chain.heading_rad is None:
        return np.zeros(2)
    forward_m = chain.stride_m * moved.pending_fraction
    return forward_m * np.array([math.sin(chain.heading_rad), math.cos(chain.heading_rad)])
