"""The two public fingerprint sets of UJI as arrays. 100 stands for not heard."""

from __future__ import annotations

import lzma
from dataclasses import dataclass

import numpy as np

from app.estimation.arrays import FloatArray, IntArray
from tests.open_data import open_data

NOT_HEARD = 100.0


@dataclass(frozen=True, slots=True, eq=False)
class FingerprintSet:
    """rssi_dbm : (n, a), NOT_HEARD where not heard.  xy_m : (n, 2).  floor, building : (n,)."""

    rssi_dbm: FloatArray
    xy_m: FloatArray
    floor: IntArray
    building: IntArray


def ujiindoorloc(name: str) -> FingerprintSet:
    """`trainingData` or `validationData`: 520 access points, Web Mercator metres."""
    table = _table("ujiindoorloc", f"{name}.csv.xz", skip_rows=1)
    floor, building = table[:, 522:524].astype(np.int64).T
    return FingerprintSet(table[:, :520], table[:, 520:522], floor, building)


def uji_library(name: str) -> FingerprintSet:
    """`trn01`, `tst01`, ... of month 1: 620 access points, one building."""
    place = _table("uji_library", "01", f"{name}crd.csv.xz")
    floor = place[:, 2].astype(np.int64)
    return FingerprintSet(_table("uji_library", "01", f"{name}rss.csv.xz"), place[:, :2], floor, np.zeros_like(floor))


def _table(*parts: str, skip_rows: int = 0) -> FloatArray:
    with lzma.open(open_data(*parts), "rt") as stream:
        return np.loadtxt(stream, delimiter=",", skiprows=skip_rows)
