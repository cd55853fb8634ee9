"""A site of two floors with ten short walks each, written as files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

START_MS = 1_574_000_000_000
WIDTH_M, HEIGHT_M = 60.0, 40.0
WALKS = 10


def write_small_site(folder: Path) -> Path:
    """Straight walks of 20 s, 15 m, west to east, one every 3 m; four access points in the corners."""
    for floor in ("F1", "F2"):
        traces = folder / floor / "path_data_files"
        traces.mkdir(parents=True)
        size = {"map_info": {"width": WIDTH_M, "height": HEIGHT_M}}
        (folder / floor / "floor_info.json").write_text(json.dumps(size))
        for number in range(WALKS):
            (traces / f"{floor.lower()}walk{number}.txt").write_text(_walk(floor, 5.0 + 3.0 * number))
    return folder


def _walk(floor: str, y_m: float) -> str:
    lines = [f"{START_MS}\tTYPE_WAYPOINT\t10.0\t{y_m}", f"{START_MS + 20_000}\tTYPE_WAYPOINT\t25.0\t{y_m}"]
    for t in range(-1000, 20_500, 20):
        up = 9.8 + 2.0 * np.sin(2 * np.pi * 1.8 * t / 1000)
        lines.append(f"{START_MS + t}\tTYPE_ACCELEROMETER\t0.0\t0.0\t{up:.4f}\t3")
        lines.append(f"{START_MS + t}\tTYPE_GYROSCOPE\t0.0\t0.0\t0.0\t3")
        lines.append(f"{START_MS + t}\tTYPE_ROTATION_VECTOR\t0.0\t0.0\t-0.70711\t3")
    corners = [(0.0, 0.0), (WIDTH_M, 0.0), (0.0, HEIGHT_M), (WIDTH_M, HEIGHT_M)]
    for t in range(1000, 20_000, 2500):
        x_m = 10.0 + 15.0 * t / 20_000
        for corner, (ax, ay) in enumerate(corners):
            rssi = round(-35 - 25 * np.log10(1 + np.hypot(x_m - ax, y_m - ay)))
            bssid = f"02:00:00:00:0{floor[1]}:0{corner}"
            lines.append(f"{START_MS + t}\tTYPE_WIFI\tname\t{bssid}\t{rssi}\t2412\t{START_MS + t}")
    return "\n".join(sorted(lines, key=lambda line: int(line[:13])))
