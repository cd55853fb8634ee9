// The HTTP API as the page needs it. Every failure becomes a Refused with the server's own words.

const KEY = "surefix-api-key";

export class Refused extends Error {
  constructor(status, detail) {
    super(sentence(detail));
    this.status = status;
  }
}

/** The server's words begin in lower case and end without a full stop; the page says more after them. */
function sentence(words) {
  const text = words.trim();
  return `${text.charAt(0).toUpperCase()}${text.slice(1)}${/[.!?]$/.test(text) ? "" : "."}`;
}

export const rememberKey = (key) => sessionStorage.setItem(KEY, key);

async function ask(path, accept) {
  const key = sessionStorage.getItem(KEY);
  const headers = { Accept: accept };
  if (key) headers.Authorization = `Bearer ${key}`;
  let response;
  try {
    response = await fetch(path, { headers, cache: "no-store" });
  } catch {
    throw new Refused(0, "The server does not answer.");
  }
  if (response.ok) return response;
  const problem = await response.json().catch(() => ({}));
  throw new Refused(response.status, problem.detail || problem.title || `The server answered ${response.status}.`);
}

const json = async (path) => (await ask(path, "application/json")).json();
const part = encodeURIComponent;

export const venues = () => json("v1/venues");
export const venue = (id) => json(`v1/venues/${part(id)}`);
export const floor = (id, name) => json(`v1/venues/${part(id)}/floors/${part(name)}`);
export const phones = (id) => json(`v1/venues/${part(id)}/phones`);

/** The raster plan as an object URL (an <img> cannot send the key), or null where there is none. */
export async function floorImage(id, name) {
  try {
    return URL.createObjectURL(await (await ask(`v1/venues/${part(id)}/floors/${part(name)}/image`, "image/png")).blob());
  } catch (error) {
    if (error.status === 404) return null;
    throw error;
  }
}

/** The page of a quality report, waited for while it is being made. */
export async function qualityPage(id, version, wait) {
  for (;;) {
    const answer = await ask(`v1/venues/${part(id)}/radio-maps/${part(version)}/quality.html`, "text/html");
    if (answer.status !== 202) return answer.blob();
    const task = answer.headers.get("Location").replace(/^\//, ""); // from the page's own address, as all else
    for (let state = await json(task); state.status !== "done"; state = await json(task)) {
      if (state.problem) throw new Refused(state.problem.status, state.problem.detail || state.problem.title);
      await wait();
    }
  }
}
