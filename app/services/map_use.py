"""Gathers how the scans of sessions fit the radio map, in memory, and writes it down beside the batches.

What counts is a visit: the scans of one session in one square, which are correlated and so count as one. A visit ends
when nothing has come from the session for IDLE_MS, or after LONGEST_MS. A process that dies loses the visits under way.
"""

from __future__ import annotations

import asyncio
import logging
import math
from collections import OrderedDict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from app.errors import DependencyDown
from app.fusion.interface import Site
from app.fusion.surefix import SUREFIX
from app.observations import Fix, Flag, RadioFix
from app.services.map_drift import MapDrift, map_drift, session_bit
from app.storage.map_use_rows import MapUseRows, UsedSquare, UseRow
from app.wifi.radio_map import RadioMap
from app.wifi.survey_likeness import LEAST_DISTANCE, Likeness, square_of, stored_likeness

PERIOD_MS = 30 * 86_400_000
"""Use is summed up in stretches of the server's clock."""
PERIODS_KEPT = 2
"""This one and the last: a change is told from one to two months of use, not watered down by years before it."""
IDLE_MS = 600_000
LONGEST_MS = 3_600_000
FLUSH_EVERY_S = 30.0
SESSIONS_HELD = 20_000
"""Sessions whose visits are under way at a time; the oldest end when there are more."""
SQUARES_WAITING = 50_000
"""While the database cannot be reached; use beyond that is not counted."""
JUDGE_EVERY_S = 600.0
_log = logging.getLogger(__name__)


@dataclass(slots=True)
class _Stay:
    """Scans of a session in a square so far."""

    scans: int = 0
    unfit: int = 0
    total: float = 0.0


@dataclass(slots=True)
class _Visitor:
    """A session under way. Times are the server's clock."""

    first_ms: int
    last_ms: int
    stays: dict[tuple[str, int, int], _Stay] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class _Surveyed:
    """The map of a venue that was used last, without the map: what its use is compared with."""

    version: int
    floors: tuple[str, ...]
    likeness: Likeness | None


class MapUse:
    """Counts use; each worker has one, and the database adds up what they write.

    Parameters
    ----------
    now_ms : the server's clock.
    tell : how many squares of a venue's map are to be surveyed again, now and then.
    """

    def __init__(
        self, rows: MapUseRows, now_ms: Callable[[], int], tell: Callable[[str, int], None] = lambda *_: None
    ) -> None:
        self._rows = rows
        self._now_ms = now_ms
        self._tell = tell
        self._surveyed: dict[str, _Surveyed] = {}
        self._told: dict[str, int] = {}
        self._visitors: OrderedDict[tuple[str, int, str], _Visitor] = OrderedDict()
        self._waiting: dict[tuple[str, int], dict[UsedSquare, UseRow]] = {}

    async def heard(self, venue: str, site: Site, session: str, method: str, fix: Fix) -> None:
        """Take up what the scans behind a new Fix say; nothing is waited for."""
        if method != SUREFIX.method:
            return  # others compare scans in other ways
        if site.radio_map is None or fix.position is None or fix.integrity.flag is Flag.FAULT:
            return  # in a fault nobody knows which square it is
        scans = [one for one in fix.evidence if isinstance(one, RadioFix) and one.source == "wifi"]
        if not scans:
            return
        self._know(venue, site.radio_map)
        now_ms, key = self._now_ms(), (venue, site.radio_map.version, session)
        visitor = self._visitors.get(key)
        if visitor is not None and now_ms - visitor.first_ms >= LONGEST_MS:
            self._ended(key)
            visitor = None
        if visitor is None:
            visitor = self._visitors[key] = _Visitor(now_ms, now_ms)
        visitor.last_ms = now_ms
        self._visitors.move_to_end(key)
        square = square_of(fix.position.x_m, fix.position.y_m)
        stay = visitor.stays.setdefault((fix.position.floor, *square), _Stay())
        stay.scans += len(scans)
        stay.unfit += sum(not one.fits for one in scans)
        stay.total += sum(math.log(max(one.signal_distance, LEAST_DISTANCE)) for one in scans)
        if len(self._visitors) > SESSIONS_HELD:
            self._ended(next(iter(self._visitors)))

    async def run(self) -> None:
        """Write down and judge for ever; ends by being cancelled."""
        judged_s = 0.0
        while True:
            await asyncio.sleep(FLUSH_EVERY_S)
            judged_s += FLUSH_EVERY_S
            self.end_idle()
            await self.flush()
            if judged_s >= JUDGE_EVERY_S:
                judged_s = 0.0
                await self.judge()

    def end_idle(self) -> None:
        """End the visits of sessions from which nothing comes any more."""
        for key in list(self._idle()):
            self._ended(key)

    async def judge(self) -> None:
        """Tell of every venue that this process serves how many squares of its map are to be surveyed again."""
        for venue, known in list(self._surveyed.items()):
            if known.likeness is None:
                continue
            try:
                drift = await self.drift(venue, known.version, known.likeness, known.floors)
            except DependencyDown as error:
                _log.warning("whether radio maps have changed is looked at later: %s", error)
                return
            count = len(drift.resurvey)
            if count > self._told.get(venue, 0):
                _log.warning("venue %s, radio map %d: survey %d squares again", venue, known.version, count)
            self._told[venue] = count
            self._tell(venue, count)

    async def drift(self, venue: str, version: int, likeness: Likeness, floors: Sequence[str]) -> MapDrift:
        """What use says of a version.

        Raises
        ------
        DependencyDown : the database cannot be reached.
        """
        return map_drift(await self._rows.read(venue, version, self.first_period()), likeness, floors)

    async def close(self) -> None:
        """End every visit, and write it down."""
        for key in list(self._visitors):
            self._ended(key)
        await self.flush()

    async def flush(self) -> None:
        """Write down the visits that have ended; what cannot be written is kept for the next time."""
        writing, self._waiting = self._waiting, {}
        if not writing:
            return
        try:
            await self._rows.add(writing)
        except DependencyDown as error:
            _log.warning("how scans fit the radio map is written down later: %s", error)
            self._keep(writing)
        except asyncio.CancelledError:
            self._keep(writing)  # the transaction was rolled back
            raise

    async def forget(self) -> None:
        """Drop periods that count no longer."""
        await self._rows.forget(self.first_period())

    def since_ms(self) -> int:
        """From when on use counts."""
        return self.first_period() * PERIOD_MS

    def first_period(self) -> int:
        """The oldest period that counts."""
        return self._now_ms() // PERIOD_MS - PERIODS_KEPT + 1

    def _know(self, venue: str, radio_map: RadioMap) -> None:
        known = self._surveyed.get(venue)
        if known is None or known.version != radio_map.version:
            likeness = stored_likeness(radio_map.sections)
            self._surveyed[venue] = _Surveyed(radio_map.version, radio_map.floors, likeness)

    def _idle(self) -> Iterator[tuple[str, int, str]]:
        now_ms = self._now_ms()
        for key, visitor in self._visitors.items():
            if now_ms - visitor.last_ms < IDLE_MS:
                break  # those after it were heard later
            yield key

    def _ended(self, key: tuple[str, int, str]) -> None:
        """A visitor's stays become visits."""
        venue, version, session = key
        visitor = self._visitors.pop(key)
        bit, period = session_bit(session), visitor.last_ms // PERIOD_MS
        for place, stay in visitor.stays.items():
            mean = stay.total / stay.scans
            row = UseRow(stay.scans, stay.unfit, 1, mean, mean * mean, bit, visitor.last_ms)
            self._keep({(venue, version): {UsedSquare(*place, period): row}})

    def _keep(self, used: dict[tuple[str, int], dict[UsedSquare, UseRow]]) -> None:
        for version, squares in used.items():
            waiting = self._waiting.setdefault(version, {})
            for square, row in squares.items():
                had = waiting.get(square)
                if had is not None:
                    waiting[square] = had.plus(row)
                elif sum(map(len, self._waiting.values())) < SQUARES_WAITING:
                    waiting[square] = row
