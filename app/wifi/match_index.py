"""What matchers look up: the radio map's values in one representation, by access point and by point.

Made once per map and representation, when first asked for, and held as long as the map is.
"""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.spatial import cKDTree

from app.estimation.arrays import Float32Array, FloatArray, IntArray
from app.wifi.radio_map import Int32Array, RadioMap
from app.wifi.representation import POWED, Representation, represent


@dataclass(frozen=True, slots=True, eq=False)
class MatchIndex:
    """A radio map of p points, a access points and n pairs, ready to be matched.

    representation : of all values.  floors, floor, xy_m, bssid : as in the map.
    start (a + 1,), point (n,), value (n,) : pairs by access point.
    row_start (p + 1,), column (n,), row_value (n,) : the same pairs by point.
    total, square : (p,) sum of a point's values, and of their squares.
    group : (a,) that access points belong to, below GROUPS.  group_square : (p, GROUPS) a point's squares by group.
    """

    representation: Representation
    floors: tuple[str, ...]
    floor: Int32Array
    xy_m: FloatArray
    bssid: IntArray
    start: IntArray
    point: Int32Array
    value: Float32Array
    row_start: IntArray
    column: Int32Array
    row_value: Float32Array
    total: FloatArray
    square: FloatArray
    group: IntArray
    group_square: FloatArray


GROUPS = 4
"""Of access points, for solution separation. 2, 8 and 16 tell less of a fix's error."""
_LEAST_VALUE = 0.003
"""Smoothed values below are left out: nearly not heard, and there are many."""
_REACH = 3.0
"""Standard deviations up to which smoothing looks."""
_held: WeakKeyDictionary[RadioMap, dict[tuple[Representation, float], MatchIndex]] = WeakKeyDictionary()


def index_of(radio_map: RadioMap, representation: Representation = POWED, smooth_m: float = 0.0) -> MatchIndex:
    """The index of a map; the same object when asked again.

    smooth_m : give each point the mean of the points around it on its floor, weighted by a Gaussian of this standard
    deviation and by their number of scans; 0 leaves them as they are.
    """
    by_kind = _held.setdefault(radio_map, {})
    index = by_kind.get((representation, smooth_m))
    if index is None:
        index = by_kind[representation, smooth_m] = _build(radio_map, representation, smooth_m)
    return index


def _build(radio_map: RadioMap, representation: Representation, smooth_m: float) -> MatchIndex:
    points, access_points = len(radio_map.scans), len(radio_map.bssid)
    # a scan that missed an access point counts as 0 of it, as a point does that never heard it
    value = represent(radio_map.mean_dbm, representation) * radio_map.share_heard
    shape = (access_points, points)
    pairs = csr_array((value, radio_map.point, radio_map.start), shape=shape)
    if smooth_m > 0.0 and points:
        pairs = pairs @ _smoothing(radio_map, smooth_m)
        pairs.data[pairs.data < _LEAST_VALUE] = 0.0
        pairs.eliminate_zeros()
    pairs.sort_indices()
    by_point = pairs.T.tocsr()
    group = groups_of(radio_map.bssid)
    group_of_pair = np.repeat(group, np.diff(pairs.indptr))
    square = pairs.data.astype(np.float64) ** 2
    cell = pairs.indices.astype(np.int64) * GROUPS + group_of_pair
    return MatchIndex(
        representation=representation,
        floors=radio_map.floors,
        floor=radio_map.floor,
        xy_m=radio_map.xy_m,
        bssid=radio_map.bssid,
        start=pairs.indptr.astype(np.int64),
        point=pairs.indices.astype(np.int32),
        value=pairs.data.astype(np.float32),
        row_start=by_point.indptr.astype(np.int64),
        column=by_point.indices.astype(np.int32),
        row_value=by_point.data.astype(np.float32),
        total=np.bincount(pairs.indices, pairs.data, minlength=points).astype(np.float64),
        square=np.bincount(pairs.indices, square, minlength=points).astype(np.float64),
        group=group,
        group_square=np.bincount(cell, square, minlength=points * GROUPS).reshape(points, GROUPS).astype(np.float64),
    )


def groups_of(bssid: IntArray) -> IntArray:
    """(a,) the group of each access point, 0 to GROUPS - 1: by chance, but one for all addresses of a radio, which
    differ in the last four bits."""
    mixed = (bssid.astype(np.uint64) >> np.uint64(4)) * np.uint64(0x9E3779B97F4A7C15)
    return np.asarray((mixed >> np.uint64(32)) % np.uint64(GROUPS), np.int64)


def _smoothing(radio_map: RadioMap, smooth_m: float) -> csr_array:
    """(p, p) what each row's point contributes to each column's: columns sum to 1."""
    # floors are set so far apart that none reaches another
    places = np.column_stack([radio_map.xy_m, 2.0 * _REACH * smooth_m * radio_map.floor])
    tree = cKDTree(places)
    near = tree.sparse_distance_matrix(tree, _REACH * smooth_m, output_type="coo_matrix")
    weight = np.exp(-0.5 * (near.data / smooth_m) ** 2) * radio_map.scans[near.row]
    total = np.bincount(near.col, weight, minlength=len(radio_map.scans))
    return csr_array(coo_array((weight / total[near.col], (near.row, near.col)), shape=near.shape).astype(np.float32))
