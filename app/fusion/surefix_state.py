"""What `surefix` knows of one session between two batches."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from app.estimation.arrays import FloatArray
from app.fusion.access_point_watch import AccessPointWatch
from app.fusion.beacon_listening import BeaconEar
from app.fusion.facing import FacingRecord
from app.fusion.fix_assembly import Phases
from app.fusion.hearing import Hearing
from app.fusion.hypotheses import Rivalry
from app.fusion.interface import SessionStart
from app.fusion.particle_cloud import Cloud, landed
from app.fusion.state_codec import storable
from app.fusion.storeys import Storeys
from app.pdr.tracker import PdrState
from app.pdr.turn_doubt import TurnRecord
from app.wifi.floor_decision import FloorBelief

storable(TurnRecord)


@storable
@dataclass(frozen=True, slots=True, eq=False)
class SurefixState:
    """Of one session. radio_s : newest usable WiFi scan; there is no position before the first scan of any kind.

    track : the account of steps and scans that is answered from.  rivalry : another one, None while nothing
    contradicts.  prior_only : the track began at the phone's `start`, and no scan has borne it out yet.
    phases : what the newest scan's test found.  storeys : what the barometer says of the floor.
    ear : what was heard of Bluetooth beacons.  watch : access points that are not relied on.
    hearing : those that the phone has heard.  turns : whether its gyroscope can be believed.  facing : how it is held.
    otherwise_m : (2,) where much that the newest scan holds is at home instead; None where nothing is.
    strange_m2 : variance that scans have lately for being unlike the survey.
    """

    start: SessionStart
    pdr: PdrState
    floor: FloorBelief | None = None
    phases: Phases = field(default_factory=Phases)
    time_s: float | None = None
    track: Cloud | None = None
    rivalry: Rivalry | None = None
    prior_only: bool = False
    radio_s: float | None = None
    turns: TurnRecord = field(default_factory=TurnRecord)
    facing: FacingRecord = field(default_factory=FacingRecord)
    step_count: int = 0
    storeys: Storeys = field(default_factory=Storeys)
    ear: BeaconEar = field(default_factory=BeaconEar)
    watch: AccessPointWatch = field(default_factory=AccessPointWatch)
    hearing: Hearing = field(default_factory=Hearing)
    otherwise_m: FloatArray | None = None
    strange_m2: float | None = None

    @property
    def heard_s(self) -> float | None:
        """The newest usable scan of either radio; None before the first."""
        heard = [at for at in (self.radio_s, self.ear.placed_s) if at is not None]
        return max(heard) if heard else None


def on_next_floor(state: SurefixState, sigma_m: float) -> SurefixState:
    """The state on another floor, both accounts where they were in plan, to sigma_m in each direction."""
    track, rivalry = state.track, state.rivalry
    if rivalry is not None:
        rivalry = replace(rivalry, rival=landed(rivalry.rival, sigma_m))
    return replace(state, track=None if track is None else landed(track, sigma_m), rivalry=rivalry)
