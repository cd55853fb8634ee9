"""What a detected step says once it is known where the phone is carried: whether it counts, its length, its heading."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from app.estimation.angles import wrap
from app.fusion.dual_settings import DualSettings
from app.fusion.heading_search import HeadingSearch
from app.fusion.state_codec import storable
from app.observations import Batch, Step
from app.pdr.carried_phone import CarriedPhone, advance_carried
from app.pdr.carried_state import CarriedMotion
from app.pdr.carrying_position import Recognised
from app.pdr.carrying_steps import constants_of, is_step, step_length_m
from app.pdr.rmpca import LEAST_CELLS, Direction, is_looked_at, walked_on

TELLS_AFTER_S = 0.15
"""Samples so long after a step's instant are enough to close its last cell."""
USUAL_SHARE = 0.8
"""Of the usual time between steps that stays when another step comes."""


@storable
@dataclass(frozen=True, slots=True, eq=False)
class Carried:
    """What is remembered of the phone and of the way it was carried.

    usual_s : time between steps, NaN before the second.  last_s : of the last step, NaN before the first.
    end_known : whether it is known which end of the axis is the way.
    frame : the attitude's, to which offset_rad belongs.  offset_rad : from the attitude's frame to north where the
    phone does not know it, None while nobody does.
    """

    phone: CarriedPhone = field(default_factory=CarriedPhone)
    direction: Direction = field(default_factory=Direction)
    usual_s: float = math.nan
    last_s: float = math.nan
    end_known: bool = False
    frame: int = 0
    offset_rad: float | None = None


for _kind in (CarriedPhone, CarriedMotion, Recognised, Direction):
    storable(_kind)


@dataclass(frozen=True, slots=True)
class CarriedStep:
    """A step that counts. step : with the length and heading of this method, the heading in the attitude's frame.
    length_sigma_m, heading_variance : of them.  north : whether the heading is from north.  end_known : and not from
    south: an axis has two ends."""

    step: Step
    length_sigma_m: float
    heading_variance: float
    north: bool
    end_known: bool = True

    @property
    def told(self) -> Step:
        """The step as evidence; its heading may be any where north or the end is unknown."""
        known = self.north and self.end_known
        return replace(self.step, heading_sigma_rad=math.sqrt(self.heading_variance) if known else math.pi)


def taken(
    carried: Carried, step: Step, batch: Batch, until_s: float | None, settings: DualSettings
) -> tuple[Carried, CarriedStep | None]:
    """The step by this method; None of one that does not pass the thresholds of where the phone is carried.

    Parameters
    ----------
    batch, until_s : whose samples the step was found in, and up to when they may be used.
    """
    cut_s = step.time_s + TELLS_AFTER_S
    phone = advance_carried(
        carried.phone, batch, settings.quaternion, cut_s if until_s is None else min(cut_s, until_s)
    )
    carried = in_frame(replace(carried, phone=phone))
    carrying = phone.recognised.at(step.time_s)
    cells = phone.motion.cells_between(step.time_s - step.duration_s, step.time_s)
    interval_s = step.time_s - carried.last_s
    if not is_step(cells, interval_s, carried.usual_s, carrying):
        return carried, None
    usual_s = carried.usual_s
    if math.isfinite(interval_s) and interval_s < 1.5 * step.duration_s:
        usual_s = interval_s if math.isnan(usual_s) else USUAL_SHARE * usual_s + (1.0 - USUAL_SHARE) * interval_s
    carried = replace(carried, usual_s=usual_s, last_s=step.time_s)
    length_m = step_length_m(cells, step.duration_s, carrying)
    sigma_m = constants_of(carrying).sigma_m
    if len(cells) < LEAST_CELLS:  # a gap: nothing but the shared detector knows of this step
        told = replace(step, length_m=length_m)
        return carried, CarriedStep(told, sigma_m, step.heading_sigma_rad**2, step.absolute)
    middle_s = step.time_s - 0.5 * step.duration_s
    direction, variance = walked_on(
        carried.direction, cells, phone.motion.pose_near(middle_s), carrying, settings.direction
    )
    before = carried.direction.heading_rad
    change_rad = wrap(direction.heading_rad - before) if math.isfinite(before) else 0.0
    told = replace(step, length_m=length_m, heading_rad=direction.heading_rad, heading_change_rad=change_rad)
    end_known = carried.end_known or is_looked_at(cells, carrying)
    found = CarriedStep(told, sigma_m, variance + settings.heading_rad**2, phone.motion.is_absolute, end_known)
    return replace(carried, direction=direction, end_known=end_known), found


def in_frame(carried: Carried) -> Carried:
    """The same, without what belonged to an attitude that was begun anew since."""
    frame = carried.phone.motion.frame
    if frame == carried.frame:
        return carried
    return replace(carried, direction=Direction(), end_known=False, frame=frame, offset_rad=None)


def turned_round(carried: Carried) -> Carried:
    """The other end of the axis: the way was taken for its opposite."""
    direction = carried.direction
    heading_rad = wrap(direction.heading_rad + math.pi)
    return replace(carried, direction=replace(direction, heading_rad=heading_rad, forward=-direction.forward))


def reversed_by(search: HeadingSearch, heading_rad: float, end_known: bool) -> bool:
    """Whether fixes show a way that is rather the opposite of the steps'.

    heading_rad : true one of the newest step.  end_known : an end that is known needs more to be given up.
    """
    return abs(wrap(heading_rad - search.heading_rad)) > math.radians(120.0 if end_known else 90.0)
