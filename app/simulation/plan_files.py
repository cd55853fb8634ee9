"""Floor plans of a simulated building as the open data has them: GeoJSON, size, and a picture."""

from __future__ import annotations

import io
from typing import Any

from PIL import Image, ImageDraw

from app.estimation.arrays import FloatArray
from app.simulation.building import Building, SimulatedFloor

PIXELS_PER_METRE = 8
_PAPER, _FLOOR, _ROOM, _WALL, _OUTER = "#ffffff", "#f7f9fb", "#d7e6ee", "#7d97a5", "#24323a"


def plan_geojson(building: Building, floor: SimulatedFloor) -> dict[str, Any]:
    """The plan in WGS 84: first the outline, whose bounding box lays out the floor's frame, then every room."""
    features = [_feature(building, floor.to_frame(floor.layout.outline), {"name": f"{building.name} {floor.floor}"})]
    for index, room in enumerate(floor.layout.rooms, start=1):
        number = f"{floor.level + 1}{index:02d}"
        properties = {"id": f"{floor.floor}-{room.name}", "name": number, "display": number}
        features.append(_feature(building, floor.to_frame(room.area.corners), properties))
    return {"type": "FeatureCollection", "features": features}


def floor_info(floor: SimulatedFloor) -> dict[str, Any]:
    """The frame's size in metres."""
    return {"map_info": {"height": floor.height_m, "width": floor.width_m}}


def plan_image(floor: SimulatedFloor) -> bytes:
    """The plan as PNG, spanning exactly the floor's frame, north up."""
    scale = PIXELS_PER_METRE
    size = round(floor.width_m * scale), round(floor.height_m * scale)
    image = Image.new("RGB", size, _PAPER)
    draw = ImageDraw.Draw(image)

    def pixels(points_m: FloatArray) -> list[tuple[float, float]]:
        return [(x * scale, size[1] - y * scale) for x, y in points_m.tolist()]

    draw.polygon(pixels(floor.to_frame(floor.layout.outline)), fill=_FLOOR)
    for room in floor.layout.rooms:
        draw.polygon(pixels(floor.to_frame(room.area.corners)), fill=_ROOM)
    for start, end in zip(floor.walls.start_m, floor.walls.end_m, strict=True):
        draw.line([(p[0] * scale, size[1] - p[1] * scale) for p in (start, end)], fill=_WALL, width=2)
    outline = pixels(floor.to_frame(floor.layout.outline))
    draw.line([*outline, outline[0]], fill=_OUTER, width=5, joint="curve")
    buffer = io.BytesIO()
    image.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def _feature(building: Building, points_m: FloatArray, properties: dict[str, Any]) -> dict[str, Any]:
    ring = []
    for x, y in [*points_m.tolist(), points_m[0].tolist()]:
        latitude, longitude = building.georeference.to_wgs84(x, y)
        ring.append([longitude, latitude])
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}
