// The page at /: polls the phones of one venue once a second and shows those of one floor on its plan.

import * as service from "./service.js";
import { Alerts } from "./alerts.js";
import { address, named, rename } from "./fragment.js";
import { fillLegend } from "./legend.js";
import { Phones, metres } from "./phones.js";
import { drawPlan } from "./plan.js";
import { openQuality } from "./quality.js";
import { drawTabs } from "./tabs.js";

const POLL_MS = 1000;
const BUILDINGS_MS = 5000; // how often venues and floors are asked for: they seldom change
const PATIENCE_MS = 4000;
const byId = (id) => document.getElementById(id);
const state = {
  venue: null,
  version: null, // of its radio map in use
  floors: [],
  floor: null,
  drawn: null,
  phones: [],
  asked: -Infinity,
  read: null, // the fragment that was followed last
};
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
  if (location.hash !== state.read || performance.now() - state.asked > BUILDINGS_MS || state.floors.length === 0) {
    state.read = location.hash;
    offerVenues((await service.venues()).venues);
    state.floors = state.venue ? [...(await service.venue(state.venue)).floors].sort((a, b) => a.level - b.level) : [];
    state.asked = performance.now();
    if (location.hash !== state.read) return look(); // somebody has gone elsewhere meanwhile
  }
  if (!state.venue) {
    clear();
    const words = "The address names one that this server does not have. Choose another above.";
    if (byId("venue").options.length > 0) return notice(`There is no venue “${named().venue}”`, words);
    return notice("No venue yet", "A venue is a building with its floors. The demo makes one with phones walking through it:", "surefix demo");
  }
  show((state.floors.find((floor) => floor.floor === state.floor) ?? state.floors[0])?.floor ?? null);
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
  const image = floor.plan && floor.georeference ? null : await service.floorImage(state.venue, state.floor);
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
  drawTabs(byId("floors"), state.floors, state.floor, state.phones, go);
  const bar = [5, 10, 20, 50, 100].find((length) => length / scale > 60) ?? 100;
  byId("scale").hidden = false;
  byId("scale-bar").style.width = `${bar / scale}px`;
  byId("scale-text").textContent = `${bar} m`;
}

function offerVenues(venues) {
  const select = byId("venue");
  byId("venue-picker").hidden = venues.length === 0;
  if (select.dataset.venues !== JSON.stringify(venues)) {
    select.dataset.venues = JSON.stringify(venues);
    select.replaceChildren(...venues.map(({ venue, name }) => new Option(name || venue, venue)));
  }
  const wanted = named();
  const found = venues.find(({ venue }) => venue === (wanted.venue ?? state.venue));
  const shown = found ?? (wanted.venue ? null : venues.at(-1)); // never another one than the address names
  if ((shown?.venue ?? null) !== state.venue) {
    Object.assign(state, { venue: shown?.venue ?? null, floor: null });
    clear();
    alerts.clear();
  }
  state.version = shown?.version ?? null;
  state.floor = wanted.floor ?? state.floor;
  select.value = state.venue ?? "";
  byId("quality").hidden = state.version === null;
}

function show(floor) {
  state.floor = floor;
  rename(state.venue, floor);
  state.read = location.hash;
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
  for (const id of ["count", "usable", "accuracy", "alerts"]) byId(id).textContent = "–";
  phones.clear();
  state.phones = [];
  state.drawn = null;
  byId("floors").dataset.names = "";
  byId("scale").hidden = true;
}

function notice(title, text, command = null, strip = false) {
  const box = byId("notice");
  const parts = [["h2", title], ["p", text], ...(command ? [["pre", command]] : [])].map(([tag, words]) => {
    const node = document.createElement(tag);
    node.textContent = words;
    return node;
  });
  box.replaceChildren(...parts);
  box.classList.toggle("strip", strip);
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

let wake = () => {};
fillLegend(byId("legend"));

byId("venue").addEventListener("change", (event) => {
  location.hash = address(event.target.value);
});
byId("key-form").addEventListener("submit", (event) => {
  event.preventDefault();
  service.rememberKey(byId("key").value.trim());
  byId("key").value = "";
  wake();
});
byId("quality").addEventListener("click", () => openQuality(state.venue, state.version));
document.querySelector(".skip").addEventListener("click", (event) => {
  event.preventDefault(); // the fragment names what is shown
  byId("phones").focus();
});
window.addEventListener("hashchange", () => wake());
window.addEventListener("resize", () => state.drawn && paint());

for (;;) {
  const wait = await turn();
  await new Promise((go) => {
    wake = go;
    setTimeout(go, wait);
  });
}
