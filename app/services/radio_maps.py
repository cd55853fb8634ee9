"""Radio-map versions of a venue: building them from surveys, publishing one, going back to an older one."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from app.errors import Conflict, InvalidInput
from app.services.identifiers import no_version
from app.services.left_behind import ShortLived
from app.services.venues import Venues
from app.services.worker_processes import WorkerProcesses
from app.storage.radio_map_rows import BuiltMap, OutdatedError, RadioMapRows, VersionRow
from app.storage.survey_rows import SurveyRows
from app.survey.spool import fingerprint_of, read_rows, write_row
from app.wifi.fingerprint import Fingerprint
from app.wifi.fix_calibration import calibrated_map
from app.wifi.radio_map_codec import encode_radio_map

ATTEMPTS = 6
"""Times that a version is built again because others published meanwhile, before the caller is told to come back."""


class RadioMaps:
    """What can be done with the radio maps of a venue.

    Each method raises NotFound where there is no such venue, DependencyDown where the database cannot be reached.

    Parameters
    ----------
    now_ms : the server's clock.
    """

    def __init__(
        self,
        rows: RadioMapRows,
        surveys: SurveyRows,
        venues: Venues,
        workers: WorkerProcesses,
        now_ms: Callable[[], int],
    ) -> None:
        self._rows = rows
        self._venues = venues
        self._surveys = surveys
        self._workers = workers
        self._now_ms = now_ms
        self._turns: dict[int, asyncio.Lock] = {}

    def turn(self, venue_id: int) -> asyncio.Lock:
        """Held while a version of the venue is made: those of this process then do not outdate one another."""
        return self._turns.setdefault(venue_id, asyncio.Lock())

    async def listed(self, venue: str) -> list[VersionRow]:
        """Every version, oldest first."""
        return await self._rows.listed(await self._venues.key(venue))

    async def build(self, venue: str, surveys: Sequence[int]) -> VersionRow:
        """Make a version of some of the venue's surveys, without activating it.

        Raises
        ------
        InvalidInput : no survey named, or one that the venue does not have.
        Conflict : others kept publishing meanwhile.
        """
        venue_id = await self._venues.key(venue)
        chosen = tuple(sorted(set(surveys)))
        if not chosen:
            raise InvalidInput("name at least one survey", "surveys")
        present = set(await self._surveys.ids(venue_id))
        for at, survey in enumerate(surveys):
            if survey not in present:
                raise InvalidInput(f"the venue has no survey {survey}", f"surveys[{at}]")
        async with self.turn(venue_id):
            for _ in range(ATTEMPTS):
                built = await self.built(venue_id, chosen, complete=False, active=False)
                now_ms = self._now_ms()
                try:
                    await self._rows.add(venue_id, built, now_ms)
                except OutdatedError:
                    continue
                return VersionRow(built.version, False, built.surveys, built.summary, now_ms)
        raise Conflict("others kept publishing radio maps of this venue; try again")

    async def activate(self, venue: str, version: int) -> None:
        """Make a version the active one: running sessions move to it at their next scan.

        Raises
        ------
        NotFound : there is no such version, too.
        """
        if not await self._rows.activate(await self._venues.key(venue), version):
            raise no_version(venue, version)

    async def built(
        self, venue_id: int, surveys: Sequence[int], complete: bool, active: bool, addition: Path | None = None
    ) -> BuiltMap:
        """The next version, built in another process and not stored yet.

        Parameters
        ----------
        complete : `surveys` are all there are.  addition : spool of a survey that is not stored yet.
        """
        version = await self._rows.newest(venue_id) + 1
        with tempfile.TemporaryDirectory(prefix=ShortLived.MAP) as folder:
            spools = []
            for survey in surveys:
                spools.append(Path(folder) / str(survey))
                with spools[-1].open("wb") as stream:
                    async for rows in self._surveys.fingerprints([survey]):
                        for row in rows:
                            write_row(stream, row)
            spools += [] if addition is None else [addition]
            body, summary, heard = await self._workers.run(encoded_map, spools, version)
        return BuiltMap(version, tuple(surveys), complete, summary, body, active, heard)


def encoded_map(spools: Sequence[Path], version: int) -> tuple[bytes, dict[str, Any], dict[int, int]]:
    """The radio map of all fingerprints in some spools, encoded, counts about it, and by access point the place of the
    last spool that holds it."""
    fingerprints, heard = list[Fingerprint](), dict[int, int]()
    for place, spool in enumerate(spools):
        with spool.open("rb") as stream:
            found = [fingerprint_of(row) for row in read_rows(stream)]
        heard |= {bssid: place for one in found for bssid in one.bssid.tolist()}
        fingerprints += found
    radio_map = calibrated_map(fingerprints, version)
    per_floor = {floor: sum(one.floor == floor for one in fingerprints) for floor in radio_map.floors}
    summary = {
        "fingerprints": len(fingerprints),
        "reference_points": len(radio_map.scans),
        "access_points": len(radio_map.bssid),
        "beacons": 0 if radio_map.beacons is None else len(radio_map.beacons.bssid),
        "floors": per_floor,
    }
    return encode_radio_map(radio_map), summary, heard
