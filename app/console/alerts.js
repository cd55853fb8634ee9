// What has happened since the page was opened: which phone's flag entered `fault`, and when it left.

const SHOWN = 8;

export class Alerts {
  /** list is an element that is announced to screen readers as it grows; none is shown while it is empty. */
  constructor(list, none) {
    Object.assign(this, { list, none, since: new Map() });
  }

  clear() {
    this.since.clear();
    this.list.replaceChildren();
    this.none.hidden = false;
  }

  /** Takes up the phones of a poll. A phone that is gone has ended its alert with its session. */
  update(phones) {
    const faulty = new Map(phones.filter(({ fix }) => fix.integrity.flag === "fault").map((phone) => [phone.phone, phone.fix]));
    const present = new Set(phones.map((phone) => phone.phone));
    for (const [phone, fix] of faulty)
      if (!this.since.has(phone)) {
        this.since.set(phone, Date.now());
        this.tell("raised", phone, fix.position ? `on ${fix.position.floor}${reason(fix)}` : reason(fix));
      }
    for (const [phone, since] of this.since)
      if (!faulty.has(phone)) {
        this.since.delete(phone);
        this.tell("cleared", phone, `after ${Math.max(1, Math.round((Date.now() - since) / 1000))} s${present.has(phone) ? "" : ", session over"}`);
      }
  }

  tell(kind, phone, words) {
    const line = document.createElement("li");
    line.dataset.alert = kind;
    line.dataset.flag = kind === "raised" ? "fault" : "nominal";
    const time = document.createElement("time");
    time.textContent = new Date().toLocaleTimeString([], { hour12: false });
    const badge = document.createElement("span");
    badge.className = "flag";
    badge.dataset.mark = kind === "raised" ? "✖" : "✓";
    badge.textContent = kind;
    const who = document.createElement("b");
    who.textContent = phone;
    line.append(time, badge, who, ` ${words.trim()}`);
    this.list.prepend(line);
    while (this.list.children.length > SHOWN) this.list.lastChild.remove();
    this.none.hidden = true;
  }
}

function reason({ integrity }) {
  const [first, ...others] = integrity.excluded;
  if (!first) return "";
  return `: ${first.bssid ?? first.observation} ${first.reason}${others.length ? ` and ${others.length} more` : ""}`;
}
