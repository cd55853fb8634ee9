"""Where an import goes: straight into a database, or to a running service over its API."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Protocol

import httpx

from app.commands.import_sources import ImportFloor
from app.commands.service_address import shown
from app.errors import Conflict, InvalidInput, NotFound, SurefixError
from app.floorplan.georeference import Georeference
from app.services.radio_maps import RadioMaps
from app.services.server_clock import server_ms
from app.services.surveys import Surveys
from app.services.venues import Venues, floor_draft, floor_extent
from app.services.worker_processes import WorkerProcesses
from app.storage.database import connect
from app.storage.migration import require_usable
from app.storage.radio_map_rows import RadioMapRows
from app.storage.survey_rows import SurveyRows
from app.storage.venue_rows import VenueRows
from app.survey.admission import FloorExtent
from app.survey.upload import SurveyFindings, SurveyFormat, Upload

PATIENCE_S = 900.0
Existing = dict[str, tuple[FloorExtent, Georeference | None]]
"""Floors of a venue by name."""


class Destination(Protocol):
    """Where venues, floors and surveys are made. Each method raises SurefixError where it is refused."""

    def floors(self, venue: str) -> Existing | None:
        """The floors of a venue; None if there is no such venue."""
        ...

    def make_venue(self, venue: str) -> None:
        """Make a venue without floors."""
        ...

    def make_floor(self, venue: str, floor: ImportFloor) -> None:
        """Make a floor, with its plan and image."""
        ...

    def add(self, venue: str, upload: Upload, findings: SurveyFindings, spool: Path, publish: bool) -> dict[str, Any]:
        """Store a survey; gives its receipt.

        Parameters
        ----------
        findings, spool : the same upload as it was read here.
        """
        ...

    def close(self) -> None:
        """Let go of connections."""
        ...


class DatabaseDestination:
    """A database that this process writes to itself."""

    def __init__(self, url: str) -> None:
        self._runner = asyncio.Runner()
        self._engine = connect(url)
        self._workers = WorkerProcesses(1)
        rows = SurveyRows(self._engine)
        self._venues = Venues(VenueRows(self._engine), server_ms)
        maps = RadioMaps(RadioMapRows(self._engine), rows, self._venues, self._workers, server_ms)
        self._surveys = Surveys(rows, self._venues, maps, self._workers, server_ms)
        self._runner.run(require_usable(self._engine))

    def floors(self, venue: str) -> Existing | None:
        try:
            _, rows = self._runner.run(self._venues.read(venue))
        except NotFound:
            return None
        return {row.floor: (floor_extent(row), row.georeference) for row in rows}

    def make_venue(self, venue: str) -> None:
        self._runner.run(self._venues.create(venue, venue))

    def make_floor(self, venue: str, floor: ImportFloor) -> None:
        plan = None if floor.plan is None else _json(floor.plan)
        draft = floor_draft(floor.floor, floor.level, floor.width_m, floor.height_m, floor.georeference, plan)
        self._runner.run(self._venues.put_floor(venue, floor.floor, draft))
        if floor.image is not None:
            self._runner.run(self._venues.put_image(venue, floor.floor, floor.image.read_bytes()))

    def add(self, venue: str, upload: Upload, findings: SurveyFindings, spool: Path, publish: bool) -> dict[str, Any]:
        venue_id, floor_ids, _ = self._runner.run(self._surveys.floors(venue))
        landing = self._surveys.land(venue_id, floor_ids, upload.format, findings, spool, publish)
        receipt = self._runner.run(landing)
        return {"survey": receipt.survey, "accepted": receipt.accepted, "version": receipt.version}

    def close(self) -> None:
        self._workers.stop()
        self._runner.run(self._engine.dispose())
        self._runner.close()


class ServiceDestination:
    """A running service. client : with its address and key."""

    def __init__(self, client: httpx.Client) -> None:
        self._client = client

    def floors(self, venue: str) -> Existing | None:
        try:
            floors = self._answer("GET", f"/v1/venues/{venue}")["floors"]
        except NotFound:
            self._refuse_other_service()
            return None
        existing: Existing = {}
        for one in floors:
            place = one["georeference"]
            frame = Georeference(place["latitude"], place["longitude"], place["rotation"]) if place else None
            existing[one["floor"]] = FloorExtent(one["floor"], one["width"], one["height"]), frame
        return existing

    def make_venue(self, venue: str) -> None:
        self._answer("POST", "/v1/venues", json={"venue": venue, "name": venue})

    def make_floor(self, venue: str, floor: ImportFloor) -> None:
        place = floor.georeference
        frame = None
        if place is not None:
            frame = {
                "latitude": place.latitude_deg,
                "longitude": place.longitude_deg,
                "rotation": place.rotation_rad,
            }
        body = {
            "name": floor.floor,
            "level": floor.level,
            "width": floor.width_m,
            "height": floor.height_m,
            "georeference": frame,
            "plan": None if floor.plan is None else _json(floor.plan),
        }
        address = f"/v1/venues/{venue}/floors/{floor.floor}"
        self._answer("PUT", address, json=body)
        if floor.image is not None:
            headers = {"Content-Type": "image/png"}
            self._answer("PUT", f"{address}/image", content=floor.image.read_bytes(), headers=headers)

    def add(self, venue: str, upload: Upload, findings: SurveyFindings, spool: Path, publish: bool) -> dict[str, Any]:
        address, query = f"/v1/venues/{venue}/surveys", {"publish": "true" if publish else "false"}
        with ExitStack() as stack:
            if upload.format is SurveyFormat.TRACES:
                query["floor"] = upload.floor or ""
                files = [("files", (name, stack.enter_context(path.open("rb")))) for name, path in upload.files]
                return self._answer("POST", address, params=query, files=files)
            body = stack.enter_context(upload.files[0][1].open("rb"))
            return self._answer("POST", address, params=query, content=body, headers={"Content-Type": "text/csv"})

    def close(self) -> None:
        self._client.close()

    def _refuse_other_service(self) -> None:
        """Nothing, if there are venues at the address. That there is not one of them, any server says of any path."""
        try:
            self._answer("GET", "/v1/venues")
        except NotFound as error:
            raise self._not_surefix() from error

    def _not_surefix(self) -> InvalidInput:
        where = shown(self._client.base_url)
        return InvalidInput(f"url: what answers at {where} is not Surefix; name the address of its console", "url")

    def _answer(self, method: str, path: str, **request: Any) -> dict[str, Any]:
        try:
            answer = self._client.request(method, path, timeout=PATIENCE_S, **request)
        except httpx.HTTPError as error:
            why = str(error) or type(error).__name__
            where = shown(self._client.base_url)
            raise SurefixError(f"{method} {where}{path}: {why}; is it served there? --url names another") from error
        if answer.is_success:
            return self._document(answer) if answer.content else {}
        kind: Callable[[str], SurefixError] = {404: NotFound, 409: Conflict, 422: InvalidInput}.get(
            answer.status_code, SurefixError
        )
        raise kind(f"{method} {path}: {answer.status_code} {_detail(answer)}")

    def _document(self, answer: httpx.Response) -> dict[str, Any]:
        try:
            return dict(answer.json())
        except (ValueError, TypeError) as error:
            raise self._not_surefix() from error


def _detail(answer: httpx.Response) -> str:
    try:
        return str(answer.json()["detail"])
    except (ValueError, KeyError, TypeError):
        return " ".join(answer.text.split())[:200]


def _json(path: Path) -> Any:
    try:
        return json.loads(path.read_text())
    except ValueError as error:
        raise InvalidInput(f"{path} is not JSON: {error}", path.name) from error
