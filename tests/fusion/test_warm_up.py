"""Warming up leaves nothing for the first request to compile."""

from __future__ import annotations

import importlib
import pkgutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from numba.core.registry import CPUDispatcher

import app
from app.fusion.methods import METHODS
from app.fusion.warm_up import warm_up
from app.observations import Batch, WifiScan
from tests.fusion.walks import run, walked

ROOT = Path(__file__).parents[2]
NOT_AT_A_REQUEST = ("app.simulation", "app.evaluation", "app.commands")


def compiled() -> dict[str, int]:
    """Signatures of every compiled function that a service may come to."""
    found = {}
    for module in pkgutil.walk_packages(app.__path__, "app."):
        if not module.name.startswith(NOT_AT_A_REQUEST) and not module.name.endswith("__main__"):
            for name, value in vars(importlib.import_module(module.name)).items():
                if isinstance(value, CPUDispatcher):
                    found[f"{value.py_func.__module__}.{name}"] = len(value.signatures)
    return found


def odd_scans(batches: tuple[Batch, ...]) -> list[Batch]:
    """A walk that hears half of the access points, then its own and another floor's at once, then another place's."""
    other = [scan for batch in walked(7).batches for scan in batch.wifi]
    upstairs = [scan for batch in walked(9, level=1).batches for scan in batch.wifi]
    heard = []
    for number, batch in enumerate(batches):
        scans = []
        for scan in batch.wifi:
            foreign = (upstairs if number < 30 else other)[number % 20]
            mine = scan.bssid % 2 == 0 if number < 30 else np.zeros(len(scan.bssid), np.bool_)
            new = ~np.isin(foreign.bssid, scan.bssid[mine]) & (number >= 15)
            bssid = np.concatenate([scan.bssid[mine], foreign.bssid[new]])
            rssi_dbm = np.concatenate([scan.rssi_dbm[mine], foreign.rssi_dbm[new] + 20.0])
            order = np.argsort(bssid)
            scans.append(WifiScan(scan.time_s, bssid[order], rssi_dbm[order], np.full(len(bssid), scan.time_s)))
        heard.append(replace(batch, wifi=tuple(scans)))
    return heard


def walk_and_print_what_is_compiled() -> None:
    """For a process in which nothing ran before."""
    warm_up()
    before = compiled()
    walks = [list(walked(5).batches[:40]), odd_scans(walked(5).batches[:60])]
    walks.append([replace(batch, rotation_vector=Batch(0, None).rotation_vector) for batch in walks[0]])
    for method in METHODS.values():
        for batches in walks:
            run(method, batches)
    after = compiled()
    print(len(before), *(name for name in after if after[name] > before[name]))


def test_walks_of_all_kinds_compile_nothing_more() -> None:
    script = "from tests.fusion.test_warm_up import walk_and_print_what_is_compiled as walk; walk()"
    told = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    functions, *late = told.split()
    assert int(functions) > 50 and late == []
