// SPDX-License-Identifier: Apache-2.0
// A photograph with its circles, warp and points, which a mouse, a finger or the keyboard moves.

const OVERLAY_SIDE = 1400; // [px] of the longer side of overlay.png
export const svgNode = (tag, attributes = {}, ...children) => {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
};

// What can be changed: its keys, and its value for a place on the picture and back.
const HANDLES = {
  diameter: { label: "specimen", unit: "m", step: 0.001, least: 0.05, most: 0.6, usual: 0.3, angle: 0 },
  support: { label: "support", unit: "m", step: 0.001, least: 0.05, most: 0.4, usual: 0.18, angle: 180 },
  warp: { label: "warp", unit: "degrees", step: 1, least: 0, most: 179, usual: 90 },
};

export class Picture {
  // change(fields) is called when the user has changed some; adds() is the kind of points that a
  // click adds.
  constructor(place, change, adds) {
    Object.assign(this, { place, change, adds, pending: {}, sent: {}, timer: 0 });
  }

  // Shows an item whose files are at `base`. The picture stays until a measurement has ended.
  async show(item, base) {
    const shown = item.state === "done" ? "photo/overlay.png" : item.file;
    const address = `${base}/${shown}?${item.state === "done" ? JSON.stringify(item.result.dc) : ""}`;
    this.item = item;
    const isOther = this.of !== item.id;
    if (this.address !== address && (isOther || item.state === "done" || item.state === "failed")) {
      this.address = address;
      if (isOther) {
        const original = new Image();
        original.src = `${base}/${item.file}`;
        await new Promise((resolve) => (original.onload = original.onerror = resolve));
        if (this.address !== address) return; // another one was opened meanwhile
        this.size = [original.naturalWidth || 4, original.naturalHeight || 3];
        this.scale = undefined; // a refused picture keeps its earlier one
        this.of = item.id;
      }
      this.draw(address);
    }
    if (this.of === item.id) this.update();
  }

  draw(address) {
    const [width, height] = this.size;
    this.unit = 1; // of handles and letters [px of the photograph]
    this.cross = [width / 2, height / 2];
    this.svg = svgNode(
      "svg",
      {
        viewBox: `0 0 ${width} ${height}`,
        tabindex: 0,
        role: "application",
        "aria-label": `Photograph ${this.item.name}: arrow keys move a cross, Enter adds a point there`,
      },
      // The overlay has lines of text below the picture, which are cut off.
      svgNode("image", { href: address, width, height, preserveAspectRatio: "xMinYMin slice" }),
    );
    this.layer = svgNode("g");
    this.crossNode = svgNode("path", { class: "cross" });
    this.svg.append(this.layer, this.crossNode);
    this.handles = {};
    for (const key of Object.keys(HANDLES)) this.addHandle(key);
    this.svg.addEventListener("click", (event) => this.addPoint(this.placeOf(event)));
    this.svg.addEventListener("keydown", (event) => this.moveCross(event));
    this.place.replaceChildren(this.svg);
  }

  placeOf(event) {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(this.svg.getScreenCTM().inverse());
    return [point.x, point.y];
  }

  addHandle(key) {
    const { label, least, most } = HANDLES[key];
    const node = svgNode("g", {
      class: "handle", tabindex: 0, role: "slider", "aria-label": label, "aria-valuemin": least, "aria-valuemax": most,
    });
    const lines = svgNode("g");
    this.layer.append(lines, node);
    this.handles[key] = { node, lines };
    node.addEventListener("pointerdown", (event) => {
      node.setPointerCapture(event.pointerId);
      event.preventDefault();
      node.focus();
    });
    node.addEventListener("pointermove", (event) => {
      if (node.hasPointerCapture(event.pointerId)) this.set(key, this.valueAt(key, this.placeOf(event)));
    });
    node.addEventListener("click", (event) => {
      event.stopPropagation();
    });
    node.addEventListener("keydown", (event) => {
      const steps = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1, PageUp: 10, PageDown: -10 }[event.key];
      if (!steps) return;
      event.preventDefault();
      event.stopPropagation();
      this.set(key, this.value(key) + steps * HANDLES[key].step);
    });
  }

  // A field as the user has set it, which the server may not know yet.
  text(key) {
    return this.pending[key] ?? this.sent[key] ?? this.item.fields[key] ?? "";
  }

  value(key) {
    const text = this.text(key);
    if (key === "warp") return { up: 90, right: 0 }[text] ?? (((parseInt(text || "90", 10) || 0) % 180) + 180) % 180;
    return Number(text) || HANDLES[key].usual;
  }

  valueAt(key, [x, y]) {
    const [dx, dy] = [x - this.centre[0], y - this.centre[1]];
    if (key === "warp") return (Math.atan2(-dy, dx) * 180) / Math.PI;
    return (2 * Math.hypot(dx, dy)) / this.scale;
  }

  // Shows a value at once, and tells it when no other one follows.
  set(key, value) {
    const { step, least, most } = HANDLES[key];
    const whole = Math.round(value / step);
    const kept = key === "warp" ? ((whole % 180) + 180) % 180 : Math.min(most, Math.max(least, whole * step));
    this.send({ [key]: String(Number(kept.toFixed(3))) });
  }

  send(fields) {
    Object.assign(this.pending, fields);
    this.update();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.flush(), 300);
  }

  // Tells what has changed.
  flush() {
    clearTimeout(this.timer);
    if (Object.keys(this.pending).length === 0) return;
    this.sent = { ...this.sent, ...this.pending };
    this.pending = {};
    this.change(this.sent);
  }

  // Fields that were sent have arrived, or are those of another photograph.
  settle(fields) {
    if (!fields || fields === this.sent) this.sent = {};
  }

  points(key) {
    const numbers = this.text(key).split(",").filter(Boolean).map(Number);
    return numbers.flatMap((x, i) => (i % 2 ? [] : [[x, numbers[i + 1]]]));
  }

  addPoint([x, y]) {
    if (!(x >= 0 && y >= 0 && x < this.size[0] && y < this.size[1])) return;
    const points = [...this.points(this.adds()), [Math.floor(x), Math.floor(y)]];
    this.send({ [this.adds()]: points.join(",") });
    this.flush();
  }

  moveCross(event) {
    const step = this.unit * (event.shiftKey ? 5 : 1);
    const move = { ArrowUp: [0, -step], ArrowDown: [0, step], ArrowLeft: [-step, 0], ArrowRight: [step, 0] }[event.key];
    if (event.target !== this.svg || (!move && event.key !== "Enter")) return;
    event.preventDefault();
    if (move) this.cross = this.cross.map((value, i) => Math.min(this.size[i] - 1, Math.max(0, value + move[i])));
    else this.addPoint(this.cross);
    this.update();
  }

  // Puts all marks where the values are. Without a measurement there is no scale, and circles are
  // hidden.
  update() {
    const { item, layer } = this;
    const box = item.state === "done" ? item.result?.specimen_in_overlay_px : undefined;
    if (box) {
      const factor = Math.max(...this.size) / OVERLAY_SIDE;
      this.centre = [factor * (box[0] + box[2] / 2), factor * (box[1] + box[3] / 2)];
      this.flat = (factor * (box[2] + box[3])) / 2; // diameter [px of the photograph]
      this.scale = this.flat / (Number(item.fields.diameter) || HANDLES.diameter.usual);
    } else if (!this.scale) {
      this.centre = this.size.map((side) => side / 2);
    }
    this.zoom();
    const { unit } = this;
    for (const key of Object.keys(HANDLES)) this.place_(key);
    layer.querySelectorAll(":scope > [data-point]").forEach((node) => node.remove());
    for (const key of ["cloth_points", "ground_points"])
      for (const [cx, cy] of this.points(key))
        layer.append(svgNode("circle", { class: key, "data-point": "", cx, cy, r: 0.9 * unit }));
    const [x, y] = this.cross;
    this.crossNode.setAttribute("d", `M${x - 2 * unit} ${y}h${4 * unit}M${x} ${y - 2 * unit}v${4 * unit}`);
  }

  // Shows the measured specimen with a margin, or the whole picture.
  zoom() {
    const [width, height] = this.size;
    const side = this.scale ? 0.75 * this.flat : Infinity;
    const half = [Math.min(width / 2, side), Math.min(height / 2, side)];
    const corner = this.centre.map((value, i) => Math.min(this.size[i] - 2 * half[i], Math.max(0, value - half[i])));
    this.svg.setAttribute("viewBox", [...corner, 2 * half[0], 2 * half[1]].join(" "));
    this.unit = Math.max(...half) / 50;
  }

  place_(key) {
    const { node, lines } = this.handles[key];
    const { label, unit, angle } = HANDLES[key];
    const value = this.value(key);
    const isWarp = key === "warp";
    const radius = isWarp ? 0.16 * Math.min(...this.size) : (value * this.scale) / 2;
    node.style.display = lines.style.display = isWarp || this.scale ? "" : "none";
    if (!isWarp && !this.scale) return;
    const turn = ((isWarp ? value : angle) * Math.PI) / 180;
    const [cx, cy] = this.centre;
    const [dx, dy] = [radius * Math.cos(turn), -radius * Math.sin(turn)];
    const shape = () =>
      isWarp
        ? svgNode("path", { d: `M${cx - dx} ${cy - dy}L${cx + dx} ${cy + dy}` })
        : svgNode("circle", { cx, cy, r: radius });
    const both = [shape(), shape()];
    both.forEach((each, i) => each.setAttribute("class", i ? "ring" : "dark"));
    lines.replaceChildren(...both);
    const text = isWarp && ["", "unknown"].includes(this.text("warp"))
      ? "warp unknown" : isWarp ? `warp ${value}°` : `${label} ${(100 * value).toFixed(1)} cm`;
    node.setAttribute("aria-valuenow", value);
    node.setAttribute("aria-valuetext", text.startsWith("warp") ? text : `${value} ${unit}`);
    node.replaceChildren(
      svgNode("circle", { cx: cx + dx, cy: cy + dy, r: 1.6 * this.unit }),
      svgNode("text", {
        x: cx + dx, y: cy + dy - 2 * this.unit, "font-size": 3 * this.unit, "text-anchor": "middle",
      }, text),
    );
  }
}
