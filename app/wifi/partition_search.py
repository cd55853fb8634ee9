"""Matching within a moving partition, and everywhere when the partition has lost its walker.

Two-stage WiFi/MEMS integration, Micromachines 2019, 10, 198, section 4.1 (docs/methods/two_stage_ekf.md).
The paper never says what happens to a walker who is no longer in the circle; here the partition is lost when

- no scan came for so long that the walker may have left the circle,
- it holds too few reference points to have neighbours, or
- its best neighbour is much less like the scan than the best neighbours of this session usually are,

and then the whole map is searched, all floors of it, and a partition begun at what was found.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from app.observations import WifiScan
from app.wifi.match import Match
from app.wifi.moving_partition import Partition, partition_around
from app.wifi.radio_map import RadioMap
from app.wifi.strongest_wknn import StrongestSettings, strongest_wknn


@dataclass(frozen=True, slots=True)
class PartitionSettings:
    """moving : False searches the whole map for every scan, the paper's comparison.

    radius_m, per_scatter : radius of a partition, the first and so many times the scatter of the neighbours that it
    begins with. The paper's 2.5 m is a second's way where points are 1.2 m apart and fixes err by 2 m; where they err
    by more, a walker soon leaves so small a circle. per_scatter was chosen on folds 1-4 of the mall walks.
    least_s, speed_mps : the fastest walker; without a scan for as long as the radius takes, and at least so long, the
    partition is lost.
    least_points : fewer neighbours are no place.
    unlike : lost where the distance to the best neighbour exceeds its usual value by this factor.
    remembered : share of the usual distance that stays when another scan comes.  strongest : of the matching itself.
    """

    moving: bool = True
    radius_m: float = 2.5
    per_scatter: float = 2.0
    least_s: float = 2.5
    speed_mps: float = 2.5
    least_points: int = 5
    unlike: float = 1.3
    remembered: float = 0.8
    strongest: StrongestSettings = field(default_factory=StrongestSettings)


@dataclass(frozen=True, slots=True, eq=False)
class SearchState:
    """partition : None while lost.  version : of the radio map whose points it holds.  time_s : of the newest scan.
    usual_db : distance to the best neighbour, usually; NaN before the first scan."""

    partition: Partition | None = None
    version: int = 0
    time_s: float = -math.inf
    usual_db: float = math.nan


def place_scan(
    state: SearchState, radio_map: RadioMap, scan: WifiScan, floor: int | None, settings: PartitionSettings
) -> tuple[SearchState, Match | None, bool]:
    """Place of a scan by what the partition holds, or by the whole map.

    Parameters
    ----------
    floor : index of the floor that the walker is on, None before it is known; a partition elsewhere is lost.

    Returns
    -------
    The next state, the match, None where the scan says too little, and whether the whole map was searched: only then
    has the match anything to say of the floor.
    """
    held = _held(state, radio_map, scan, floor, settings)
    if held is not None:
        match = strongest_wknn(radio_map, scan.bssid, scan.rssi_dbm, settings.strongest, held.floor, held.points)
        if match is not None and match.signal_distance <= settings.unlike * state.usual_db:
            x_m, y_m = match.xy_m.tolist()
            moved = partition_around(radio_map, held.floor, x_m, y_m, held.radius_m)
            return _after(state, radio_map, scan, match, moved, settings), match, False
    match = strongest_wknn(radio_map, scan.bssid, scan.rssi_dbm, settings.strongest)
    if match is None:
        return state, None, True
    if not settings.moving:
        return state, match, True
    x_m, y_m = match.xy_m.tolist()
    radius_m = settings.radius_m + settings.per_scatter * math.sqrt(float(match.covariance_m2.trace()))
    partition = partition_around(radio_map, match.floor, x_m, y_m, radius_m)
    return _after(state, radio_map, scan, match, partition, settings), match, True


def _held(
    state: SearchState, radio_map: RadioMap, scan: WifiScan, floor: int | None, settings: PartitionSettings
) -> Partition | None:
    partition = state.partition
    if partition is None or state.version != radio_map.version or partition.floor != floor:
        return None
    if len(partition.points) < settings.least_points:
        return None
    silent_s = scan.time_s - state.time_s
    return partition if silent_s <= max(settings.least_s, partition.radius_m / settings.speed_mps) else None


def _after(
    state: SearchState,
    radio_map: RadioMap,
    scan: WifiScan,
    match: Match,
    partition: Partition,
    settings: PartitionSettings,
) -> SearchState:
    usual_db, kept = match.signal_distance, settings.remembered
    if math.isfinite(state.usual_db):
        usual_db = kept * state.usual_db + (1.0 - kept) * usual_db
    return SearchState(partition, radio_map.version, scan.time_s, usual_db)
