// What the marks on the map and in the table mean.

import { element } from "./plan.js";
import { FLAGS } from "./phones.js";

const NOSE = ["line", "nose", { x1: 3.5, y1: -3.5, x2: 7.5, y2: -7.5 }];
const MARKS = [
  ["the phone", "dot, with its heading", [NOSE, ["circle", "core", { r: 5 }]]],
  ["68 % circle", "the phone is inside it two times in three", [["circle", "accuracy", { r: 10 }]]],
  ["protection level", "it is outside only at the risk agreed", [["circle", "protection", { r: 10 }]]],
];

export function fillLegend(list) {
  for (const [name, meaning, shapes] of MARKS) {
    const picture = element("svg", { viewBox: "-16 -11 32 22", "aria-hidden": "true" });
    picture.append(...shapes.map(([kind, mark, size]) => element(kind, { class: mark, ...size })));
    list.append(line(picture, `${name}: ${meaning}`));
  }
  for (const [flag, [mark, meaning]] of Object.entries(FLAGS)) {
    const badge = document.createElement("span");
    badge.className = "flag";
    Object.assign(badge.dataset, { flag, mark });
    badge.textContent = flag;
    list.append(line(badge, meaning));
  }
}

function line(picture, meaning) {
  const node = document.createElement("li");
  node.dataset.flag = "nominal";
  node.append(picture, meaning);
  return node;
}
