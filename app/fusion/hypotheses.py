"""Two accounts of where the walker is, and which of them scans and steps bear out.

A fix far from where the steps lead may be a relayed radio, access points that were moved, or a walker who was carried
off: at first they look alike. So the track that steps and earlier scans made stays as it was, a rival begins at the
fix, and both walk on. The rival takes over only after scans on a stretch of way fit it and not the first.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from app.fusion.particle_cloud import Cloud
from app.fusion.state_codec import storable


@dataclass(frozen=True, slots=True)
class HypothesisSettings:
    """contradicts : squared Mahalanobis distance of a fix from a track beyond which it speaks against it. On 165
    clean mall walks (folds 1-4) one scan in a thousand exceeds 12, and no two in a row exceed 6.
    fault_after, enough_against : contradictions in a row that are a fault if their squared distances add up to so much.
    surely_after : those that are one whatever they add up to.
    back_after : scans in a row that bear the first track out again and end the fault.
    moved_after, moved_m : scans, and metres of steps, that must bear the rival out and not the first before answers
    are given from it. They are no use yet: the radio of somebody else's walk fits one's own for as long by chance.
    prior_after : scans that must contradict a mere `start` of the phone's.
    here_m, unlike_here : a fix from afar contradicts the track only if its scan sounds less like what was surveyed
    within here_m of it, by this signal distance. Of clean scans placed too far off half exceed 0.04 to 0.2 in simulated
    buildings, and in the mall 0.11 to 0.14; scans of places 40 m off exceed 0.28 in 99 of 100.
    settled_after, settled_m : the same until the phone may rely on it, and the account given up is forgotten.
    """

    contradicts: float = 12.0
    fault_after: int = 2
    enough_against: float = 60.0
    surely_after: int = 4
    back_after: int = 2
    here_m: float = 6.0
    unlike_here: float = 0.15
    moved_after: int = 5
    moved_m: float = 10.0
    settled_after: int = 22
    settled_m: float = 45.0
    prior_after: int = 2

    def are_fault(self, contradictions: int, against: float) -> bool:
        """Whether so many contradictions in a row, whose squared distances add up to this, are a fault."""
        return contradictions >= (self.fault_after if against >= self.enough_against else self.surely_after)

    def beside_a_prior(self) -> HypothesisSettings:
        """For a first track that nothing but the phone's own word speaks for: it is given up as soon as it is a fault,
        and the scans' place is settled after as many scans as else make a rival answer, walked or not: the word does
        not bind."""
        return replace(
            self,
            enough_against=0.0,
            moved_after=self.prior_after,
            moved_m=0.0,
            settled_after=self.moved_after,
            settled_m=0.0,
        )


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Rivalry:
    """The rival and its record.

    witness_s : the newest scan that counts.
    contradictions, against : scans in a row that speak against the first track, and the sum of their squared distances.
    fault : whether the phone has been warned.
    for_first : scans in a row that bear out the first track.  for_rival : those that bear out the rival alone.
    walked_m : steps since the rival began.
    taken_over : whether what answers now was the rival, and the rival is the account it took over from.
    """

    rival: Cloud
    witness_s: float
    contradictions: int = 1
    against: float = 0.0
    fault: bool = False
    for_first: int = 0
    for_rival: int = 1
    walked_m: float = 0.0
    taken_over: bool = False


def judged(
    rivalry: Rivalry,
    statistic: float,
    first_fits: bool,
    rival_fits: bool,
    time_s: float,
    settings: HypothesisSettings,
    explained: bool = False,
) -> Rivalry:
    """The record after one more scan, at this time. One that only repeats what the record counts is not to be judged:
    it is no second witness.

    statistic : its squared distance from the first track.
    explained : it sounds like where the first track is as well, so that it contradicts it no more than it bears it out.
    """
    counted = not first_fits and not explained
    contradictions = 0 if first_fits else rivalry.contradictions + counted
    against = 0.0 if first_fits else rivalry.against + (statistic if counted else 0.0)
    return replace(
        rivalry,
        witness_s=time_s,
        contradictions=contradictions,
        against=against,
        fault=rivalry.fault or settings.are_fault(contradictions, against),
        for_first=rivalry.for_first + 1 if first_fits else 0,
        for_rival=rivalry.for_rival + 1 if rival_fits and not first_fits else rivalry.for_rival if rival_fits else 0,
    )


def first_is_back(rivalry: Rivalry, settings: HypothesisSettings) -> bool:
    """Whether the first track is believed, again or by now. Before the phone was warned one scan is enough."""
    if rivalry.taken_over:
        return rivalry.for_first >= settings.settled_after and rivalry.walked_m >= settings.settled_m
    return rivalry.for_first >= (settings.back_after if rivalry.fault else 1)


def rival_wins(rivalry: Rivalry, settings: HypothesisSettings) -> bool:
    """Whether scans bear out that the walker is where the rival is. Who took over by mistake is put back sooner."""
    enough = settings.back_after if rivalry.taken_over else settings.moved_after
    far_m = 0.0 if rivalry.taken_over else settings.moved_m
    return rivalry.for_rival >= enough and rivalry.walked_m >= far_m


def exchanged(rivalry: Rivalry, first: Cloud) -> Rivalry:
    """The rivalry after the rival has taken over from the first track, or has been put back: in either case a fault."""
    return replace(
        rivalry,
        rival=first,
        fault=True,
        contradictions=0,
        against=0.0,
        for_first=rivalry.for_rival,
        for_rival=0,
        taken_over=not rivalry.taken_over,
    )
