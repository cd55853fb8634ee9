// Opens the quality report of a radio map in a tab of its own, which by itself could not send the key.

import * as service from "./service.js";

const WAIT_MS = 2000;

/** Must be called from a click, or the browser opens no tab. */
export async function openQuality(venue, version) {
  const tab = window.open("", "_blank");
  if (!tab) return; // the browser tells that it has blocked it
  tab.sessionStorage.clear(); // opening it has copied the key
  const tell = (words) => tab.closed || tab.document.body.replaceChildren(words);
  tab.document.title = "Radio map quality";
  tell("The quality report of this radio map is being made, which takes up to a minute.");
  try {
    const report = await service.qualityPage(venue, version, () => new Promise((go) => setTimeout(go, WAIT_MS)));
    // never revoked: the tab can be loaded again while the console is open
    if (!tab.closed) tab.location.replace(URL.createObjectURL(report));
  } catch (error) {
    if (!(error instanceof service.Refused)) throw error;
    tell(`There is no report to show. ${error.message}`);
  }
}
