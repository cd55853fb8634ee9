from __future__ import annotations

import copy
import json
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.errors import InvalidInput, TooLarge
from app.floorplan import plan as plan_module
from app.floorplan.plan import accept_plan
from tests.open_data import open_data

OUTER = [[120.0, 30.0], [120.1, 30.0], [120.1, 30.1], [120.0, 30.1], [120.0, 30.0]]
HOLE = [[120.02, 30.02], [120.02, 30.04], [120.04, 30.04], [120.04, 30.02], [120.02, 30.02]]
JUNK: tuple[Any, ...] = (None, True, 7, "x", {}, [[]], ["a", "b"], [None], {"t": 1})


def collection(*geometries: Any) -> dict[str, Any]:
    features = [{"type": "Feature", "properties": {}, "geometry": geometry} for geometry in geometries]
    return {"type": "FeatureCollection", "features": features}


def polygon(*rings: Any) -> dict[str, Any]:
    return {"type": "Polygon", "coordinates": list(rings)}


def doubled_area(ring: list[list[float]]) -> float:
    return sum(a[0] * b[1] - b[0] * a[1] for a, b in pairwise(ring))


def rings_of(plan: Any) -> list[tuple[bool, list[list[float]]]]:
    """Every ring of polygons, and whether it is a hole."""
    rings = []
    for feature in plan["features"]:
        geometry = feature["geometry"]
        polygons = [geometry["coordinates"]] if geometry["type"] == "Polygon" else geometry["coordinates"]
        rings += [(index > 0, ring) for one in polygons for index, ring in enumerate(one)]
    return rings


def test_a_plan_as_the_standard_asks_is_kept_as_it_is() -> None:
    sent = collection(
        polygon(OUTER, HOLE),
        {"type": "MultiPolygon", "coordinates": [[OUTER], [OUTER, HOLE]]},
        {"type": "Point", "coordinates": [120.0, 30.0, 4.5]},
        {"type": "MultiPoint", "coordinates": [[120.0, 30.0]]},
        {"type": "LineString", "coordinates": [[120.0, 30.0], [120.1, 30.1]]},
        {"type": "MultiLineString", "coordinates": [[[120.0, 30.0], [120.1, 30.1]]]},
        {"type": "GeometryCollection", "geometries": [polygon(OUTER), {"type": "Point", "coordinates": [120, 30]}]},
        None,
    )
    accepted = accept_plan(sent)
    assert accepted.plan == sent
    assert accepted.warnings == ()
    assert accepted.bounds == (120.0, 30.0, 120.1, 30.1)


def test_members_that_the_standard_does_not_know_are_kept() -> None:
    sent = collection({**polygon(OUTER), "z": 1})
    sent["source"] = {"any": [1, "thing"]}
    sent["features"][0] |= {"id": 5, "order": 2, "properties": {"name": "Café", "point": [1, 2]}}
    assert accept_plan(sent).plan == sent


def test_the_old_crs_is_kept_and_told() -> None:
    crs = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    of_wgs_84 = accept_plan({**collection(polygon(OUTER)), "crs": crs})
    assert of_wgs_84.plan["crs"] == crs
    assert "no longer part" in of_wgs_84.warnings[0]
    odd: Any
    for odd in ({"type": "name", "properties": {"name": "EPSG:3857"}}, "EPSG:4326", {"properties": []}, 5):
        (warning,) = accept_plan({**collection(polygon(OUTER)), "crs": odd}).warnings
        assert "whatever it says" in warning


def test_rings_are_wound_and_closed_and_the_caller_keeps_what_it_sent() -> None:
    sent = collection(polygon(OUTER[::-1], HOLE[::-1]), polygon(OUTER[:-1]))
    before = copy.deepcopy(sent)
    accepted = accept_plan(sent)
    assert sent == before
    assert [(hole, doubled_area(ring) < 0, ring[0] == ring[-1]) for hole, ring in rings_of(accepted.plan)] == [
        (False, False, True),
        (True, True, True),
        (False, False, True),
    ]
    turned, closed = accepted.warnings
    assert "turned round" in turned and "2 times, first plan.features[0].geometry.coordinates[0]" in turned
    assert closed.endswith("(plan.features[1].geometry.coordinates[0])")


def test_a_repaired_plan_needs_no_repair() -> None:
    sent = collection(polygon(OUTER[::-1], HOLE[:-1]), {"type": "LineString", "coordinates": []})
    sent["features"].append({"type": "Feature"})
    repaired = accept_plan(sent)
    assert len(repaired.warnings) == 5
    again = accept_plan(repaired.plan)
    assert again.plan == repaired.plan and again.warnings == ()


@pytest.mark.parametrize("sent", [polygon(OUTER), collection(polygon(OUTER))["features"][0]])
def test_a_single_geometry_or_feature_becomes_a_collection(sent: dict[str, Any]) -> None:
    accepted = accept_plan(sent)
    assert accepted.plan == collection(polygon(OUTER))
    assert "FeatureCollection" in accepted.warnings[0]


def test_a_real_plan_is_accepted_whole_with_its_oddities_told() -> None:
    sent = json.loads(open_data("mall", "F1", "geojson_map.json").read_text())
    accepted = accept_plan(sent)
    assert len(accepted.plan["features"]) == len(sent["features"]) == 173
    assert accepted.plan["features"][0]["crs"] == sent["features"][0]["crs"]
    assert all(doubled_area(ring) > 0 for _, ring in rings_of(accepted.plan))
    assert len(accepted.warnings) == 2


@pytest.mark.parametrize(
    ("sent", "field"),
    [
        (5, "plan"),
        ([], "plan"),
        ({}, "plan.type"),
        ({"type": "Topology"}, "plan.type"),
        ({"type": ["Polygon"]}, "plan.type"),
        ({"type": "FeatureCollection"}, "plan.features"),
        ({"type": "FeatureCollection", "features": {}}, "plan.features"),
        ({"type": "FeatureCollection", "features": [5]}, "plan.features[0]"),
        ({"type": "FeatureCollection", "features": [{"type": "Polygon"}]}, "plan.features[0].type"),
        (collection(5), "plan.features[0].geometry"),
        (collection({"type": "Circle"}), "plan.features[0].geometry.type"),
        (collection({"type": "Polygon"}), "plan.features[0].geometry.coordinates"),
        (collection(polygon(OUTER), polygon(OUTER[:2])), "plan.features[1].geometry.coordinates[0]"),
        (collection(polygon(OUTER, [])), "plan.features[0].geometry.coordinates[1]"),
        (collection(polygon([OUTER[0]] * 3)), "plan.features[0].geometry.coordinates[0]"),
        (collection({"type": "LineString", "coordinates": [[1, 2]]}), "plan.features[0].geometry.coordinates"),
        (collection({"type": "Point", "coordinates": [1]}), "plan.features[0].geometry.coordinates"),
        (collection({"type": "Point", "coordinates": [30.0, 120.0]}), "plan.features[0].geometry.coordinates[1]"),
        (collection({"type": "Point", "coordinates": [400, 0]}), "plan.features[0].geometry.coordinates[0]"),
        (collection({"type": "Point", "coordinates": [float("nan"), 0]}), "plan.features[0].geometry.coordinates[0]"),
        (collection({"type": "Point", "coordinates": [0, 0, True]}), "plan.features[0].geometry.coordinates[2]"),
        (collection({"type": "GeometryCollection"}), "plan.features[0].geometry.geometries"),
        (
            {**collection(), "features": [{"type": "Feature", "properties": [], "geometry": None}]},
            "plan.features[0].properties",
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused_by_path(sent: Any, field: str) -> None:
    with pytest.raises(InvalidInput) as refusal:
        accept_plan(sent)
    assert refusal.value.field == field


@given(st.integers(0, 1), st.integers(0, 4), st.integers(0, 1), st.sampled_from([junk for junk in JUNK if junk != 7]))
def test_any_coordinate_that_is_no_number_is_refused_by_path(ring: int, point: int, axis: int, junk: Any) -> None:
    sent = collection(polygon(copy.deepcopy(OUTER), copy.deepcopy(HOLE)))
    sent["features"][0]["geometry"]["coordinates"][ring][point][axis] = junk
    with pytest.raises(InvalidInput) as refusal:
        accept_plan(sent)
    assert refusal.value.field == f"plan.features[0].geometry.coordinates[{ring}][{point}][{axis}]"


@given(
    st.recursive(
        st.sampled_from((*JUNK, "Polygon", "Feature", "FeatureCollection", "GeometryCollection", 1e308)),
        lambda inner: (
            st.lists(inner, max_size=4)
            | st.dictionaries(
                st.sampled_from(("type", "features", "geometry", "coordinates", "geometries", "properties", "crs")),
                inner,
            )
        ),
    )
)
def test_anything_at_all_is_accepted_or_refused_with_a_path(anything: Any) -> None:
    try:
        accepted = accept_plan(anything)
    except InvalidInput as refusal:
        assert refusal.field.startswith("plan")
    else:
        assert accepted.plan["type"] == "FeatureCollection"


def test_collections_within_collections_end_somewhere() -> None:
    geometry: dict[str, Any] = {"type": "Point", "coordinates": [1, 2]}
    for _ in range(400):
        geometry = {"type": "GeometryCollection", "geometries": [geometry]}
    with pytest.raises(InvalidInput, match="deep"):
        accept_plan(collection(geometry))


def test_a_plan_has_a_bounded_number_of_positions(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan_module, "MOST_POSITIONS", 9)
    accept_plan(collection({"type": "MultiPoint", "coordinates": [[1, 2]] * 9}))
    with pytest.raises(TooLarge) as refusal:
        accept_plan(collection({"type": "MultiPoint", "coordinates": [[1, 2]] * 10}))
    assert refusal.value.field == "plan.features[0].geometry.coordinates[9]"
