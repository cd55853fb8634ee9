// The page at /: polls the phones of one venue once a second and shows those of one floor on its plan.

import * as service from "./service.js";
import { Alerts } from "./alerts.js";
import { drawPlan, element } from "./plan.js";
import { FLAGS, Phones, metres } from "./phones.js";

const POLL_MS = 1000;
const BUILDINGS_MS = 5000; // how often venues and floors are asked for: they seldom change
const PATIENCE_MS = 4000;
const byId = (id) => document.getElementById(id);
const state = { venue: null, floors: [], floor: null, drawn: null, phones: [], asked: -Infinity };
const phones = new Phones(byId("dots"), byId("trails"), byId("rows"), choose);
const alerts = new Alerts(byId("alert-list"), byId("no-alerts"));

// ---- what is asked of the server --------------------------------------------------------------------------------------

async function turn() {
  try {
    await look();
    byId("key-form").hidden = true;
    link("live", "live");
    return POLL_MS;
  } catch (error) {
    if (!(error instanceof service.Refused)) {
      link("lost", "page error");
      notice("This page has a defect", `${error}. Reload it; if it comes back, report it.`, null, true);
      throw error;
    }
    refuse(error);
    return PATIENCE_MS;
  }
}

async function look() {
  if (performance.now() - state.asked > BUILDINGS_MS || state.floors.length === 0) {
    offerVenues((await service.venues()).venues);
    state.floors = state.venue ? [...(await service.venue(state.venue)).floors].sort((a, b) => a.level - b.level) : [];
    state.asked = performance.now();
  }
  if (!state.venue) {
    clear();
    return notice("No venue yet", "A venue is a building with its floors. The demo makes one with phones walking through it:", "surefix demo");
  }
  if (!state.floors.some((floor) => floor.floor === state.floor)) show(state.floors[0]?.floor ?? null);
  if (!state.floor) {
    clear();
    return notice("This venue has no floor", "Give it one, with its size, georeference and plan:", `PUT /v1/venues/${state.venue}/floors/F1`);
  }
  await draw();
  state.phones = (await service.phones(state.venue)).phones;
  alerts.update(state.phones);
  paint();
  if (state.phones.length === 0)
    notice("Nobody is here", "Phones appear when an app opens a session and sends batches. To see some walk:", "surefix demo", true);
  else byId("notice").hidden = true;
}

async function draw() {
  const wanted = `${state.venue}/${state.floor}`;
  if (state.drawn === wanted) return;
  const floor = await service.floor(state.venue, state.floor);
  const image = floor.plan ? null : await service.floorImage(state.venue, state.floor);
  drawPlan(byId("map"), byId("plan"), floor, image);
  state.drawn = wanted;
  byId("map-title").textContent = `Floor plan of ${floor.name || floor.floor}`;
}

// ---- what is shown ------------------------------------------------------------------------------------------------------

function paint() {
  const scale = metresPerPixel();
  phones.update(state.phones, state.floor, scale);
  const fixes = state.phones.map((phone) => phone.fix);
  const radii = fixes.map((fix) => fix.accuracy).filter((radius) => radius !== null).sort((a, b) => a - b);
  const usable = fixes.filter((fix) => fix.integrity.usable).length;
  byId("count").textContent = fixes.length;
  byId("usable").textContent = fixes.length ? `${Math.round((100 * usable) / fixes.length)} %` : "–";
  byId("accuracy").textContent = metres(radii[Math.floor(radii.length / 2)]);
  byId("alerts").textContent = fixes.filter((fix) => fix.integrity.flag === "fault").length;
  byId("no-phones").hidden = fixes.length > 0;
  tabs();
  const bar = [5, 10, 20, 50, 100].find((length) => length / scale > 60) ?? 100;
  byId("scale").hidden = false;
  byId("scale-bar").style.width = `${bar / scale}px`;
  byId("scale-text").textContent = `${bar} m`;
}

function tabs() {
  const here = (name) => state.phones.filter((phone) => phone.fix.position?.floor === name).length;
  const list = byId("floors");
  const names = state.floors.map((floor) => floor.floor).join("/");
  if (list.dataset.names !== names) {
    list.dataset.names = names;
    list.replaceChildren(...state.floors.map((floor) => tab(floor)));
  }
  for (const button of list.children) {
    const selected = button.dataset.floor === state.floor;
    button.setAttribute("aria-selected", selected);
    button.tabIndex = selected ? 0 : -1;
    button.lastChild.textContent = here(button.dataset.floor) || "";
  }
}

function tab(floor) {
  const button = document.createElement("button");
  button.type = "button";
  button.role = "tab";
  button.dataset.floor = floor.floor;
  button.setAttribute("aria-controls", "stage");
  const badge = document.createElement("span");
  badge.className = "badge";
  button.append(floor.name || floor.floor, badge);
  button.addEventListener("click", () => go(floor.floor));
  button.addEventListener("keydown", (event) => {
    const next = { ArrowRight: button.nextSibling, ArrowLeft: button.previousSibling }[event.key];
    if (!next) return;
    next.focus();
    next.click();
  });
  return button;
}

function offerVenues(venues) {
  const select = byId("venue");
  byId("venue-picker").hidden = venues.length === 0;
  if (select.dataset.venues !== JSON.stringify(venues)) {
    select.dataset.venues = JSON.stringify(venues);
    select.replaceChildren(...venues.map(({ venue, name }) => new Option(name || venue, venue)));
  }
  if (!venues.some(({ venue }) => venue === state.venue)) {
    const [wanted, floor] = location.hash.slice(1).split("/").map(decodeURIComponent);
    state.venue = venues.find(({ venue }) => venue === wanted)?.venue ?? venues.at(-1)?.venue ?? null;
    state.floor = floor || null;
    phones.clear();
  }
  select.value = state.venue ?? "";
}

function show(floor) {
  state.floor = floor;
  if (floor) history.replaceState(null, "", `#${encodeURIComponent(state.venue)}/${encodeURIComponent(floor)}`);
}

async function go(floor) {
  show(floor);
  try {
    await draw();
    paint();
  } catch (error) {
    if (!(error instanceof service.Refused)) throw error;
    refuse(error);
  }
}

function choose(id) {
  phones.chosen = phones.chosen === id ? null : id;
  const floor = state.phones.find((phone) => phone.phone === id)?.fix.position?.floor;
  if (floor && floor !== state.floor) go(floor);
  else paint();
}

function clear() {
  for (const id of ["plan", "floors"]) byId(id).replaceChildren();
  phones.clear();
  state.drawn = null;
  byId("floors").dataset.names = "";
  byId("scale").hidden = true;
}

function notice(title, text, command = null, corner = false) {
  const box = byId("notice");
  const parts = [["h2", title], ["p", text], ...(command ? [["pre", command]] : [])].map(([tag, words]) => {
    const node = document.createElement(tag);
    node.textContent = words;
    return node;
  });
  box.replaceChildren(...parts);
  box.classList.toggle("corner", corner);
  box.hidden = false;
}

function refuse(error) {
  if (error.status === 401 || error.status === 403) {
    clear();
    byId("notice").hidden = true;
    byId("key-form").hidden = false;
    if (sessionStorage.length) byId("key-why").textContent = `${error.message} Create a key that may read every phone of a venue:`;
    return link("lost", "needs a key");
  }
  link("lost", error.status ? "refused" : "not connected");
  return notice(error.status ? "The server refused" : "Not connected", `${error.message} Trying again every few seconds.`, null, true);
}

function link(name, words) {
  const line = byId("link");
  line.dataset.state = name;
  if (line.textContent !== words) line.textContent = words;
}

function metresPerPixel() {
  const matrix = byId("map").getScreenCTM();
  return matrix && matrix.a > 0 ? 1 / matrix.a : 0.2;
}

// ---- start ----------------------------------------------------------------------------------------------------------------

byId("legend").append(
  ...[
    ["the phone", "dot, with its heading", [["core", 5]]],
    ["68 % circle", "the phone is inside it two times in three", [["accuracy", 10]]],
    ["protection level", "it is outside only at the risk agreed", [["protection", 10]]],
  ].map(([name, meaning, circles]) => {
    const picture = element("svg", { viewBox: "-16 -11 32 22", "aria-hidden": "true" });
    picture.append(...circles.map(([kind, r]) => element("circle", { class: kind, r })));
    return legendLine(name, meaning, picture);
  }),
  ...Object.entries(FLAGS).map(([flag, [mark, meaning]]) => {
    const badge = document.createElement("span");
    badge.className = "flag";
    Object.assign(badge.dataset, { flag, mark });
    badge.textContent = flag;
    return legendLine(null, meaning, badge);
  }),
);

function legendLine(name, meaning, picture) {
  const line = document.createElement("li");
  line.dataset.flag = "nominal";
  line.append(picture, name ? `${name}: ${meaning}` : meaning);
  return line;
}

byId("venue").addEventListener("change", (event) => {
  Object.assign(state, { venue: event.target.value, floors: [], floor: null });
  clear();
  alerts.clear();
});
byId("key-form").addEventListener("submit", (event) => {
  event.preventDefault();
  service.rememberKey(byId("key").value.trim());
  byId("key").value = "";
  turn();
});
window.addEventListener("resize", () => state.drawn && paint());

for (;;) {
  const wait = await turn();
  await new Promise((wake) => setTimeout(wake, wait));
}
