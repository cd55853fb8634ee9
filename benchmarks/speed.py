"""Speed of the parts and of the whole, against other people's code in the same run: `make bench`.

Absolute times belong to the machine; the ratios are asserted. Ends with code 1 where one is missed.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import ahrs
import httpx
import numpy as np
import orjson
from rich.console import Console

from app.api.batch_body import parse_batch
from app.api.decoding import packing_of
from app.evaluation.scoring import quantile
from app.observations import Batch
from app.pdr.tracker import advance_pdr, initial_pdr_state
from app.simulation.batches import batch_bodies
from app.simulation.recording import SURVEY_PHONE, World, make_world, record_walk
from app.simulation.visitors import answer, open_venue, survey_venue
from benchmarks.candidates import candidates
from benchmarks.local_server import local_server
from benchmarks.positioning import filter_step, matching, smoothing
from benchmarks.timing import Row, median_us, show

RATE_HZ = 50.0
SEED = 5
SURVEY_WALKS = 20
HTTP_BATCHES = 600


def recorded_seconds(world: World) -> list[bytes]:
    """A walk as the bodies of its batches, one a second."""
    rng = np.random.default_rng(SEED)
    floor = world.building.floors[0]
    recording = record_walk(world, floor, SURVEY_PHONE, 1.7e9, 250.0, RATE_HZ, rng)
    return [orjson.dumps(body) for body in batch_bodies(recording, world.access_points)]


def dead_reckoning(batches: list[Batch]) -> Iterator[Row]:
    """One second of attitude, steps and heading; the reference does the attitude only."""
    state = initial_pdr_state()
    for batch in batches[:20]:
        state, _ = advance_pdr(state, batch)
    second = batches[20]
    madgwick = ahrs.filters.Madgwick(gain=0.12, frequency=RATE_HZ)
    streams = (second.gyroscope.values, second.accelerometer.values, 1e3 * second.magnetometer.values)

    def attitude_only() -> None:
        q = np.array([1.0, 0.0, 0.0, 0.0])
        for gyr, acc, mag in zip(*streams, strict=False):
            q = madgwick.updateMARG(q, gyr=gyr, acc=acc, mag=mag)

    ours, reference = median_us(lambda: advance_pdr(state, second), attitude_only)
    yield Row("dead reckoning, 1 s at 50 Hz", ours, "ahrs Madgwick, attitude only", reference, at_least=10.0)


def decoding(bodies: list[bytes]) -> Iterator[Row]:
    """One batch body to a validated Batch; the reference only parses it."""
    body = max(bodies, key=len)
    json = packing_of("application/json")
    ours, reference = median_us(lambda: parse_batch(body, json), lambda: orjson.loads(body))
    yield Row(
        f"batch body of {len(body) / 1000:.0f} kB, validated", ours, "orjson, parsed only", reference, at_least=0.1
    )


def over_http(world: World, bodies: list[bytes]) -> Iterator[Row]:
    """A phone's batches, one after the other, to a server of one worker on this machine."""
    with tempfile.TemporaryDirectory(prefix="surefix-bench-") as folder, local_server(Path(folder)) as client:
        open_venue(client, world)
        for _ in survey_venue(client, world, SURVEY_WALKS, SEED):
            pass
        spent_us: list[float] = []
        while len(spent_us) < HTTP_BATCHES:
            session = answer(client.post("/v1/sessions", json={"venue": world.building.name}), 201)["session"]
            spent_us += islice(_walk_over_http(client, session, bodies), HTTP_BATCHES - len(spent_us))
    yield Row(f"HTTP batch, p50 of {HTTP_BATCHES}", quantile(spent_us, 0.5))
    yield Row(f"HTTP batch, p99 of {HTTP_BATCHES}", quantile(spent_us, 0.99))


def _walk_over_http(client: httpx.Client, session: str, bodies: list[bytes]) -> Iterator[float]:
    headers = {"Content-Type": "application/json"}
    for body in bodies:
        began = time.perf_counter()
        response = client.post(f"/v1/sessions/{session}/batches", content=body, headers=headers)
        yield 1e6 * (time.perf_counter() - began)
        answer(response, 200)


def main() -> int:
    """Measure, print, and say by the exit code whether every ratio holds."""
    console = Console(stderr=True)
    world = make_world("benchmark", "mall", 2, SEED)
    bodies = recorded_seconds(world)
    batches = [parse_batch(body, packing_of("application/json")) for body in bodies]
    rows: list[Row] = []
    inner = (filter_step(), matching(300), matching(5000), candidates(), smoothing())
    for part in (dead_reckoning(batches), decoding(bodies), *inner, over_http(world, bodies)):
        rows += part
        console.print(f"{len(rows)} measured", style="dim")
    show(rows)
    return 0 if all(row.holds for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
