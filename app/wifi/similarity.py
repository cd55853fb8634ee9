"""How unlike the reference points of a radio map are to one another."""

from __future__ import annotations

import numpy as np
from scipy import sparse

from app.estimation.arrays import FloatArray, IntArray
from app.wifi.match_index import index_of
from app.wifi.radio_map import RadioMap


def point_distances(radio_map: RadioMap, points: IntArray) -> FloatArray:
    """(m, m) cosine distances between reference points, as app/wifi/wknn.py measures scans; 1 where nothing is shared.

    Parameters
    ----------
    points : (m,) those to compare.
    """
    index = index_of(radio_map)
    size = len(radio_map.scans), len(radio_map.bssid)
    value = sparse.csr_matrix((index.row_value.astype(np.float64), index.column, index.row_start), shape=size)[points]
    length = np.sqrt(index.square[points])
    value = sparse.diags(1.0 / np.where(length > 0.0, length, 1.0)) @ value
    distance = 1.0 - np.asarray((value @ value.T).todense(), np.float64)
    return np.clip(distance, 0.0, 1.0)
