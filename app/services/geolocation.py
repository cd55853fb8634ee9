"""Where one scan was taken, among all venues: stateless, for clients that know neither venues nor sessions."""

from __future__ import annotations

from dataclasses import dataclass

from app.observations import WifiScan
from app.services.site_cache import SiteCache
from app.storage.venue_rows import VenueRows
from app.wifi.locate import locate_scan

FEWEST = 2
"""Access points that a venue must know of a scan: one alone can be anywhere, or carried away."""


@dataclass(frozen=True, slots=True)
class Place:
    """A position in WGS 84, degrees. accuracy_m : 68 % radius."""

    latitude_deg: float
    longitude_deg: float
    accuracy_m: float


class Geolocation:
    """Finds the venue that knows most of a scan's access points, and the place in it."""

    def __init__(self, venues: VenueRows, sites: SiteCache) -> None:
        self._venues = venues
        self._sites = sites
        self._index: dict[str, tuple[int, frozenset[int]]] = {}

    async def place(self, scan: WifiScan) -> Place | None:
        """Where the scan was taken; None where no venue with a georeference can tell.

        Raises
        ------
        DependencyDown : the database cannot be reached.
        """
        heard = set(scan.bssid.tolist())
        if len(heard) < FEWEST:
            return None
        venues = await self._venues.revisions()
        shared = {venue: len(heard & await self._known_in(venue, revision)) for venue, revision in venues}
        self._index = {venue: held for venue, held in self._index.items() if venue in shared}
        for venue, revision in sorted(venues, key=lambda one: -shared[one[0]]):
            if shared[venue] < FEWEST:
                break
            place = await self._place_in(venue, revision, scan)
            if place is not None:
                return place
        return None

    async def _known_in(self, venue: str, revision: int) -> frozenset[int]:
        held = self._index.get(venue)
        if held is None or held[0] != revision:
            site = await self._sites.site(venue, revision)
            known = frozenset[int]() if site.radio_map is None else frozenset(site.radio_map.bssid.tolist())
            held = self._index[venue] = (revision, known)
        return held[1]

    async def _place_in(self, venue: str, revision: int, scan: WifiScan) -> Place | None:
        site = await self._sites.site(venue, revision)
        located = None if site.radio_map is None else locate_scan(site.radio_map, scan)
        if located is None:
            return None
        floor = site.floors.get(located.position.floor)
        if floor is None or floor.georeference is None:
            return None
        latitude, longitude = floor.georeference.to_wgs84(located.position.x_m, located.position.y_m)
        return Place(latitude, longitude, located.accuracy_m)
