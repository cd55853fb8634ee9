// Phones on the map and in the table: one marker and one row each, moved rather than redrawn.

import { element } from "./plan.js";

export const FLAGS = {
  nominal: ["●", "all measurements agree"],
  corrected: ["◆", "a poor measurement was weighed down"],
  outlier: ["▲", "an isolated wrong measurement was removed"],
  fault: ["✖", "alert: do not trust this position"],
  coasting: ["◌", "no radio for a while: dead reckoning"],
  initialising: ["…", "no position yet"],
};
const TRAIL = 45;

export class Phones {
  /** choose(phone) is called when somebody picks a phone on the map or in the table. */
  constructor(dots, trails, rows, choose) {
    Object.assign(this, { dots, trails, rows, choose, chosen: null });
    this.shown = new Map();
  }

  clear() {
    this.shown.clear();
    for (const group of [this.dots, this.trails, this.rows]) group.replaceChildren();
  }

  /** Shows the phones of a poll; scale is metres per pixel, so that dots keep their size. */
  update(phones, floor, scale) {
    const present = new Set(phones.map((phone) => phone.phone));
    for (const [id, one] of this.shown) {
      if (present.has(id)) continue;
      for (const node of [one.marker, one.trail, one.row]) node.remove();
      this.shown.delete(id);
    }
    for (const [at, phone] of phones.entries()) {
      const one = this.shown.get(phone.phone) ?? this.appear(phone.phone);
      // rows are in the order of the poll; those in place are not touched, or a focused one would lose the focus
      if (this.rows.children[at] !== one.row) this.rows.insertBefore(one.row, this.rows.children[at] ?? null);
      this.move(one, phone, floor, scale);
      this.tell(one, phone);
    }
  }

  appear(id) {
    const pick = () => this.choose(id);
    const trail = element("polyline", { class: "trail" });
    const marker = element("g", { class: "phone" });
    const place = element("g", { class: "place" });
    const parts = { protection: "circle", accuracy: "circle", nose: "line", core: "circle", tag: "text" };
    for (const [name, kind] of Object.entries(parts)) {
      parts[name] = element(kind, { class: name });
      place.append(parts[name]);
    }
    parts.tag.textContent = id;
    marker.append(place);
    marker.addEventListener("click", pick);

    const row = document.createElement("tr");
    const cells = ["name", "flag", "floor", "accuracy", "level", "usable"].map((name) => {
      const cell = document.createElement(name === "name" ? "th" : "td");
      if (name === "accuracy" || name === "level") cell.className = "number";
      row.append(cell);
      return [name, cell];
    });
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = id;
    cells[0][1].scope = "row";
    cells[0][1].append(button);
    row.addEventListener("click", pick);

    this.trails.append(trail);
    this.dots.append(marker);
    const one = { trail, marker, place, parts, row, cells: Object.fromEntries(cells), track: [], floor: null };
    this.shown.set(id, one);
    return one;
  }

  move(one, { phone, fix }, floor, scale) {
    const at = fix.position;
    const here = at !== null && at.floor === floor;
    one.marker.toggleAttribute("hidden", !here);
    one.marker.style.display = one.trail.style.display = here ? "" : "none";
    one.marker.classList.toggle("chosen", phone === this.chosen);
    one.marker.dataset.flag = one.trail.dataset.flag = fix.integrity.flag;
    if (!at) return;
    if (one.floor !== at.floor) one.track = [];
    const jump = one.track.length === 0 || Math.hypot(at.x - one.track.at(-1)[0], at.y - one.track.at(-1)[1]) > 15;
    one.floor = at.floor;
    one.track = [...one.track, [at.x, at.y]].slice(-TRAIL);
    one.trail.setAttribute("points", one.track.map(([x, y]) => `${x.toFixed(2)},${(-y).toFixed(2)}`).join(" "));
    one.place.style.setProperty("--glide", jump ? "0s" : "1s");
    one.place.style.transform = `translate(${at.x.toFixed(2)}px, ${(-at.y).toFixed(2)}px)`;
    const size = 6.5 * scale;
    one.parts.protection.setAttribute("r", fix.integrity.protection_level);
    one.parts.accuracy.setAttribute("r", fix.accuracy);
    one.parts.core.setAttribute("r", size);
    const [sin, cos] = fix.heading === null ? [0, 0] : [Math.sin(fix.heading), Math.cos(fix.heading)];
    for (const [name, value] of Object.entries({ x1: sin * size, y1: -cos * size, x2: 2.1 * sin * size, y2: -2.1 * cos * size }))
      one.parts.nose.setAttribute(name, value);
    for (const [name, value] of Object.entries({ x: 1.9 * size, y: -1.3 * size, "font-size": 12 * scale }))
      one.parts.tag.setAttribute(name, value);
  }

  tell(one, { phone, fix }) {
    const { flag, usable, protection_level: level } = fix.integrity;
    one.row.classList.toggle("chosen", phone === this.chosen);
    one.row.dataset.flag = flag;
    const badge = document.createElement("span");
    badge.className = "flag";
    badge.dataset.mark = FLAGS[flag]?.[0] ?? "?";
    badge.textContent = flag;
    if (one.cells.flag.textContent !== flag) one.cells.flag.replaceChildren(badge);
    one.cells.floor.textContent = fix.position?.floor ?? "–";
    one.cells.accuracy.textContent = metres(fix.accuracy);
    one.cells.level.textContent = metres(level);
    one.cells.usable.textContent = usable ? "yes" : "no";
    one.cells.usable.className = usable ? "" : "no";
  }
}

export const metres = (value) => (value === null || value === undefined ? "–" : `${value.toFixed(1)} m`);
