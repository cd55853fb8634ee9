"""A floor's plan as it is sent: GeoJSON (RFC 7946), repaired where real ones are odd, refused where not drawable.

Members that the RFC does not know are kept. Every repair is told to the sender.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from app.errors import InvalidInput, TooLarge

MOST_POSITIONS = 500_000
MOST_FEATURES = 100_000
DEEPEST = 8
"""Collections within collections."""
LONGITUDE_LIMIT_DEG = 360.0
"""Beyond 180 where a plan crosses the antimeridian without being cut."""
_DEPTH = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
"""How deep the positions of each kind of geometry lie."""
_WGS_84 = ("CRS84", "EPSG:4326", "EPSG::4326")


@dataclass(frozen=True, slots=True)
class AcceptedPlan:
    """A plan that can be drawn.

    plan : always a FeatureCollection.  warnings : what was repaired, or looks wrong.  bounds : west, south, east and
    north of its positions, degrees; None of a plan without any.
    """

    plan: Mapping[str, Any]
    warnings: tuple[str, ...]
    bounds: tuple[float, float, float, float] | None


def accept_plan(sent: Any, name: str = "plan") -> AcceptedPlan:
    """The plan, repaired: rings closed and wound as RFC 7946 asks, single features and geometries made a collection.

    Parameters
    ----------
    sent : decoded JSON; it is not changed.  name : how the paths in errors and warnings begin.

    Raises
    ------
    InvalidInput : the structure cannot be drawn; names the first offending element,
        e.g. `plan.features[3].geometry.coordinates[0][2]`.
    TooLarge : more positions or features than the bounds.
    """
    if not isinstance(sent, Mapping):
        raise InvalidInput("a plan is a GeoJSON object", name)
    work = _Work()
    match sent.get("type"):
        case "FeatureCollection":
            plan = _collection(sent, name, work)
        case "Feature":
            plan = {"type": "FeatureCollection", "features": [_feature(sent, name, work)]}
            work.warn("a single Feature was put into a FeatureCollection", name)
        case str(kind) if kind in _DEPTH or kind == "GeometryCollection":
            feature = {"type": "Feature", "properties": {}, "geometry": _geometry(sent, name, work, 0)}
            plan = {"type": "FeatureCollection", "features": [feature]}
            work.warn("a single geometry was put into a FeatureCollection", name)
        case _:
            raise InvalidInput("a plan is a FeatureCollection, a Feature or a geometry", f"{name}.type")
    return AcceptedPlan(plan, work.warnings(), work.bounds())


@dataclass(slots=True)
class _Work:
    """What happened on the way: the positions, and each kind of repair with how often and where first."""

    longitudes: list[float] = field(default_factory=list)
    latitudes: list[float] = field(default_factory=list)
    found: dict[str, tuple[int, str]] = field(default_factory=dict)

    def warn(self, what: str, path: str) -> None:
        count, first = self.found.get(what, (0, path))
        self.found[what] = (count + 1, first)

    def warnings(self) -> tuple[str, ...]:
        return tuple(
            f"{what} ({path})" if count == 1 else f"{what} ({count} times, first {path})"
            for what, (count, path) in self.found.items()
        )

    def bounds(self) -> tuple[float, float, float, float] | None:
        if not self.longitudes:
            return None
        return min(self.longitudes), min(self.latitudes), max(self.longitudes), max(self.latitudes)


def _collection(sent: Mapping[str, Any], path: str, work: _Work) -> dict[str, Any]:
    features = sent.get("features")
    if not isinstance(features, list):
        raise InvalidInput("a FeatureCollection has a list of features", f"{path}.features")
    if len(features) > MOST_FEATURES:
        raise TooLarge(f"a plan has at most {MOST_FEATURES} features", f"{path}.features")
    _look_at_crs(sent, path, work)
    repaired = [_feature(one, f"{path}.features[{index}]", work) for index, one in enumerate(features)]
    return {**sent, "features": repaired}


def _feature(sent: Any, path: str, work: _Work) -> dict[str, Any]:
    if not isinstance(sent, Mapping):
        raise InvalidInput("a feature is an object", path)
    if sent.get("type") != "Feature":
        raise InvalidInput("the type of a feature is `Feature`", f"{path}.type")
    _look_at_crs(sent, path, work)
    feature = dict(sent)
    properties = sent.get("properties")
    if "properties" not in sent:
        work.warn("a feature without properties was given null", path)
        feature["properties"] = None
    elif properties is not None and not isinstance(properties, Mapping):
        raise InvalidInput("the properties of a feature are an object or null", f"{path}.properties")
    if sent.get("geometry") is None:
        if "geometry" not in sent:
            work.warn("a feature without a geometry was given null", path)
        feature["geometry"] = None
    else:
        feature["geometry"] = _geometry(sent["geometry"], f"{path}.geometry", work, 0)
    return feature


def _geometry(sent: Any, path: str, work: _Work, depth: int) -> dict[str, Any] | None:
    """The geometry, repaired; None in place of an empty one, as RFC 7946 (3.1) allows."""
    if not isinstance(sent, Mapping):
        raise InvalidInput("a geometry is an object", path)
    kind = sent.get("type")
    if kind == "GeometryCollection":
        members = sent.get("geometries")
        if not isinstance(members, list):
            raise InvalidInput("a GeometryCollection has a list of geometries", f"{path}.geometries")
        if depth >= DEEPEST:
            raise InvalidInput(f"collections lie at most {DEEPEST} deep in one another", f"{path}.geometries")
        parts = [_geometry(one, f"{path}.geometries[{i}]", work, depth + 1) for i, one in enumerate(members)]
        return {**sent, "geometries": [part for part in parts if part is not None]}
    if not isinstance(kind, str) or kind not in _DEPTH:
        raise InvalidInput(f"the type of a geometry is one of {', '.join(_DEPTH)}, GeometryCollection", f"{path}.type")
    coordinates = sent.get("coordinates")
    if coordinates == []:
        work.warn("an empty geometry was made null", path)
        return None
    return {**sent, "coordinates": _coordinates(kind, coordinates, f"{path}.coordinates", work)}


def _coordinates(kind: str, sent: Any, path: str, work: _Work) -> Any:
    match kind:
        case "Point":
            return _position(sent, path, work)
        case "MultiPoint":
            return _positions(sent, path, work, 0)
        case "LineString":
            return _positions(sent, path, work, 2)
        case "Polygon":
            return [
                _ring(ring, f"{path}[{i}]", work, hole=i > 0) for i, ring in enumerate(_list(sent, path, "rings", 1))
            ]
    inner = kind.removeprefix("Multi")
    return [_coordinates(inner, part, f"{path}[{i}]", work) for i, part in enumerate(_list(sent, path, "parts", 1))]


def _ring(sent: Any, path: str, work: _Work, hole: bool) -> list[Any]:
    ring = _positions(sent, path, work, 3)
    if ring[0] != ring[-1]:
        work.warn("a ring was closed", path)
        ring.append(ring[0])
    if len(ring) < 4:
        raise InvalidInput("a ring has at least three corners and ends where it begins", path)
    doubled = _doubled_area(ring)
    if doubled == 0.0:
        work.warn("a ring encloses nothing", path)
    elif (doubled > 0.0) == hole:
        work.warn("a ring was turned round: outer ones run anticlockwise, holes clockwise", path)
        ring.reverse()
    return ring


def _doubled_area(ring: list[Any]) -> float:
    """Twice the signed area of a closed ring, positive anticlockwise, about its first corner."""
    x0, y0 = ring[0][0], ring[0][1]
    return math.fsum((a[0] - x0) * (b[1] - y0) - (b[0] - x0) * (a[1] - y0) for a, b in pairwise(ring))


def _positions(sent: Any, path: str, work: _Work, fewest: int) -> list[Any]:
    return [
        _position(one, f"{path}[{i}]", work) for i, one in enumerate(_list(sent, path, "positions", max(fewest, 1)))
    ]


def _position(sent: Any, path: str, work: _Work) -> list[Any]:
    if not isinstance(sent, list) or len(sent) < 2:
        raise InvalidInput("a position is a list of longitude and latitude, and what may follow", path)
    if len(work.longitudes) >= MOST_POSITIONS:
        raise TooLarge(f"a plan has at most {MOST_POSITIONS} positions", path)
    for index, value in enumerate(sent):
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise InvalidInput("a coordinate is a finite number", f"{path}[{index}]")
    if not -90.0 <= sent[1] <= 90.0:
        raise InvalidInput("a latitude is -90 to 90 degrees; positions are [longitude, latitude]", f"{path}[1]")
    if not -LONGITUDE_LIMIT_DEG <= sent[0] <= LONGITUDE_LIMIT_DEG:
        raise InvalidInput("a longitude is in degrees of WGS 84", f"{path}[0]")
    work.longitudes.append(sent[0])
    work.latitudes.append(sent[1])
    return sent


def _list(sent: Any, path: str, what: str, fewest: int) -> list[Any]:
    if not isinstance(sent, list) or len(sent) < fewest:
        raise InvalidInput(f"must be a list of at least {fewest} {what}", path)
    return sent


def _look_at_crs(sent: Mapping[str, Any], path: str, work: _Work) -> None:
    """The member `crs` of GeoJSON before RFC 7946: kept, and coordinates read as WGS 84 all the same."""
    crs = sent.get("crs")
    if crs is None:
        return
    properties = crs.get("properties") if isinstance(crs, Mapping) else None
    name = properties.get("name") if isinstance(properties, Mapping) else None
    if isinstance(name, str) and name.upper().endswith(_WGS_84):
        work.warn("`crs` is no longer part of GeoJSON and was kept without effect", f"{path}.crs")
    else:
        work.warn("`crs` was kept without effect; coordinates are read as WGS 84 whatever it says", f"{path}.crs")
