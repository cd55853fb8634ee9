"""Simulated people who use the service over HTTP: they survey a building, then walk through it with phones."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import httpx
import numpy as np

from app.errors import SurefixError
from app.simulation.batches import batch_bodies
from app.simulation.climb import Climbing
from app.simulation.plan_files import plan_geojson, plan_image
from app.simulation.recording import VISITOR_PHONES, World, record_climb, record_walk
from app.simulation.site import survey_walks
from app.simulation.trace_writer import trace_bytes

RATE_HZ = 50.0
SURVEY_WALK_M = (40.0, 110.0)
VISIT_M = (150.0, 400.0)
WAIT_AFTER_FAILURE_S = 2.0


class UnexpectedAnswerError(SurefixError):
    """The service answered a simulated client with something else than the contract promises."""


def answer(response: httpx.Response, *statuses: int) -> Any:
    """The JSON of an answer with one of the expected statuses.

    Raises
    ------
    UnexpectedAnswerError : any other status, with the service's words.
    """
    if response.status_code not in statuses:
        request = response.request
        raise UnexpectedAnswerError(
            f"{request.method} {request.url.path} answered {response.status_code}, "
            f"not {' or '.join(map(str, statuses))}: {response.text[:300]}"
        )
    return response.json() if response.content else None


def open_venue(client: httpx.Client, world: World) -> bool:
    """Create the building's venue with floors and plans; False where it was there already."""
    building = world.building
    created = client.post("/v1/venues", json={"venue": building.name, "name": f"Simulated {building.kind}"})
    if created.status_code == httpx.codes.CONFLICT:
        return False
    answer(created, 201)
    place = building.georeference
    for floor in building.floors:
        body = {
            "name": f"Floor {floor.level + 1}",
            "level": floor.level,
            "width": floor.width_m,
            "height": floor.height_m,
            "georeference": {"latitude": place.latitude_deg, "longitude": place.longitude_deg, "rotation": 0.0},
            "plan": plan_geojson(building, floor),
        }
        address = f"/v1/venues/{building.name}/floors/{floor.floor}"
        answer(client.put(address, json=body), 200, 201)
        image = client.put(f"{address}/image", content=plan_image(floor), headers={"Content-Type": "image/png"})
        answer(image, 200, 201, 204)
    return True


def survey_venue(client: httpx.Client, world: World, walks: int, seed: int) -> Iterator[str]:
    """Survey every floor and publish the radio map; yields after each walk and each upload what was done."""
    for floor in world.building.floors:
        files = []
        for name, recording in survey_walks(world, floor, walks, seed, RATE_HZ, SURVEY_WALK_M):
            content = trace_bytes(recording, world.access_points, world.building.name)
            files.append(("files", (f"{name}.txt", content, "text/plain")))
            yield f"walking {floor.floor}"
        query = {"floor": floor.floor, "publish": "true" if floor is world.building.floors[-1] else "false"}
        answer(client.post(f"/v1/venues/{world.building.name}/surveys", params=query, files=files), 201)
        yield f"surveyed {floor.floor}"


class Visitors:
    """Phones that walk through a venue in real time, each visit a session of its own, until stopped.

    speed : seconds of the phones' clocks in one second.  report : told of a visit that failed, and why.
    """

    def __init__(self, world: World, seed: int, speed: float, report: Callable[[str], None]) -> None:
        self._world, self._seed, self._speed, self._report = world, seed, speed, report
        self.batches_sent = 0

    async def walk(self, client: httpx.AsyncClient, number: int) -> None:
        """One visit after the other with phone `number`, for ever; ends only by being cancelled."""
        visit = 0
        while True:
            try:
                await self._visit(client, number, visit)
            except (httpx.HTTPError, UnexpectedAnswerError) as error:
                self._report(f"phone {number + 1}: {error or type(error).__name__}")
                await asyncio.sleep(WAIT_AFTER_FAILURE_S)
            visit += 1

    async def _visit(self, client: httpx.AsyncClient, number: int, visit: int) -> None:
        rng = np.random.default_rng([self._seed, 3, number, visit])
        floors = self._world.building.floors
        floor, phone = floors[(number + visit) % len(floors)], VISITOR_PHONES[number % len(VISITOR_PHONES)]
        way_m = float(rng.uniform(*VISIT_M))
        record = partial(record_walk, self._world, floor)
        if len(floors) > 1 and visit % 2:  # every other visit goes on to the next floor
            levels, how = (floor.level, (floor.level + 1) % len(floors)), list(Climbing)[visit // 2 % 2]
            record, way_m = partial(record_climb, self._world, levels, how), way_m / 2.0
        recording = await asyncio.to_thread(record, phone, time.time(), way_m, RATE_HZ, rng)
        began, first_ms = time.monotonic(), 1000 * float(recording.walk.time_s[0])
        opening = {"venue": self._world.building.name, "device": {"brand": phone.brand, "model": phone.model}}
        session = answer(await client.post("/v1/sessions", json=opening), 201)["session"]
        try:
            for body in batch_bodies(recording, self._world.access_points):
                due_s = (body["end"] - first_ms) / 1000 / self._speed
                await asyncio.sleep(max(began + due_s - time.monotonic(), 0.0))
                answer(await client.post(f"/v1/sessions/{session}/batches", json=body), 200)
                self.batches_sent += 1
        finally:
            # whoever leaves takes their data along; shielded, because leaving may be because of a cancellation
            await asyncio.shield(client.delete(f"/v1/sessions/{session}"))
