// The address's fragment, `#venue/floor`: what is shown, so that it can be kept and sent.

/** Venue and floor that the address names, each null where it names none; a malformed fragment names nothing. */
export function named() {
  try {
    const [venue, floor] = location.hash.slice(1).split("/").map(decodeURIComponent);
    return { venue: venue || null, floor: floor || null };
  } catch {
    return { venue: null, floor: null };
  }
}

/** Makes the address name what is shown, without a new entry in the history. */
export function rename(venue, floor) {
  const fragment = address(venue, floor);
  if (location.hash !== fragment) history.replaceState(null, "", fragment);
}

export const address = (...names) => `#${names.filter(Boolean).map(encodeURIComponent).join("/")}`;
