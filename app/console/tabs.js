// The floors of a venue as tabs, each with how many phones are on it.

/** go(floor) is called when somebody picks one. */
export function drawTabs(list, floors, shown, phones, go) {
  const names = floors.map((floor) => floor.floor).join("/");
  if (list.dataset.names !== names) {
    list.dataset.names = names;
    list.replaceChildren(...floors.map((floor) => tab(floor, go)));
  }
  for (const button of list.children) {
    const selected = button.dataset.floor === shown;
    const here = phones.filter((phone) => phone.fix.position?.floor === button.dataset.floor).length;
    button.setAttribute("aria-selected", selected);
    button.tabIndex = selected ? 0 : -1;
    button.lastChild.textContent = here || "";
  }
}

function tab(floor, go) {
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
