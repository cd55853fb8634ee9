// Draws a floor in metres: x to the right is east, y is turned over because SVG's grows downwards.

const METRES_PER_DEGREE = 111319.49;

export function element(name, attributes = {}, text = null) {
  const node = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== null) node.textContent = text;
  return node;
}

function localiser({ latitude, longitude, rotation }) {
  const scale = METRES_PER_DEGREE * Math.cos((latitude * Math.PI) / 180);
  const [c, s] = [Math.cos(rotation || 0), Math.sin(rotation || 0)];
  return ([lon, lat]) => {
    const [east, north] = [(lon - longitude) * scale, (lat - latitude) * METRES_PER_DEGREE];
    return [c * east - s * north, s * east + c * north];
  };
}

function rings(geometry) {
  if (geometry?.type === "Polygon") return [geometry.coordinates];
  if (geometry?.type === "MultiPolygon") return geometry.coordinates;
  if (geometry?.type === "GeometryCollection") return geometry.geometries.flatMap(rings);
  return [];
}

/** Fills the group and sets the view of the map. Returns how many shapes were drawn. */
export function drawPlan(map, group, floor, imageUrl) {
  const span = Math.max(floor.width, floor.height);
  const margin = 0.03 * span;
  map.setAttribute("viewBox", [-margin, -floor.height - margin, floor.width + 2 * margin, floor.height + 2 * margin].join(" "));
  const shapes = [];
  if (floor.plan && floor.georeference) {
    const local = localiser(floor.georeference);
    floor.plan.features.forEach((feature, index) => {
      for (const polygon of rings(feature.geometry)) shapes.push(...drawn(polygon.map((ring) => ring.map(local)), feature, index, span));
    });
    // rooms cover the inner half of the outline: its line is drawn again on top
    for (const outline of shapes.filter((shape) => shape.classList.contains("outline"))) {
      const line = outline.cloneNode();
      line.classList.add("line");
      shapes.push(line);
    }
  } else if (imageUrl) {
    const frame = { x: 0, y: -floor.height, width: floor.width, height: floor.height, preserveAspectRatio: "none" };
    shapes.push(element("image", { href: imageUrl, ...frame }));
  } else {
    shapes.push(element("rect", { class: "outline", x: 0, y: -floor.height, width: floor.width, height: floor.height }));
  }
  // names last: a room that overlaps another would be painted over its name
  group.replaceChildren(...shapes.sort((one, other) => (one.tagName === "text") - (other.tagName === "text")));
  return shapes.length;
}

function drawn(polygon, feature, index, span) {
  const d = polygon.map((ring) => `M${ring.map(([x, y]) => `${x.toFixed(2)},${(-y).toFixed(2)}`).join("L")}Z`).join("");
  const shapes = [element("path", { d, class: index ? "room" : "outline", "fill-rule": "evenodd" })];
  const name = feature.properties?.display || "";
  const [xs, ys] = [polygon[0].map((p) => p[0]), polygon[0].map((p) => p[1])];
  const [width, height] = [Math.max(...xs) - Math.min(...xs), Math.max(...ys) - Math.min(...ys)];
  const size = Math.min(0.0135 * span, 0.3 * height, (1.5 * width) / Math.max(name.length, 1));
  if (index && name && size > 0.006 * span) {
    const at = { x: Math.min(...xs) + width / 2, y: -(Math.min(...ys) + height / 2), "font-size": size.toFixed(2) };
    shapes.push(element("text", { class: "room-name", ...at }, name));
  }
  return shapes;
}
