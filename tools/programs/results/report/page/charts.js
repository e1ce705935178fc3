// SPDX-License-Identifier: Apache-2.0
// Draws the chart descriptions of solver/job/plot/chart.h, which gnuplot draws as PNG.
import { dot, gridX, gridY, line, plot, rect, ruleX, ruleY, text } from "@observablehq/plot";

// As in chart.cc, but for black, which is the colour of text here.
const COLOURS = ["currentColor", "#0072b2", "#e69f00", "#009e73", "#d55e00", "#cc79a7", "#56b4e9"];
const SYMBOLS = {
  disc: "circle",
  square: "square",
  triangle: "triangle",
  diamond: "diamond",
  triangle_down: "triangle",
  pentagon: "hexagon",
  ring: "circle",
  cross: "times",
};

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function makeLook(series, index) {
  const given = series.colour === "#000000" ? "currentColor" : series.colour;
  return {
    colour: given ?? COLOURS[index % COLOURS.length],
    dashed: series.dashed || (!given && index >= COLOURS.length),
    width: series.width ?? 2,
    size: 4 * (series.size ?? 1),
    symbol: SYMBOLS[series.symbol ?? "disc"],
    hollow: series.symbol === "ring" || series.symbol === "cross",
  };
}

// Rows {x, y, v, z}: z counts the pieces between gaps.
function makeRows(series, chart) {
  const shown = (value, axis) => value !== null && !(axis.log && value <= 0);
  const values = series.values ?? [];
  let piece = 0;
  const rows = [];
  series.points.forEach(([x, y], i) => {
    const v = values.length ? values[i] : undefined;
    if (!shown(x, chart.x) || !shown(y, chart.y) || v === null) {
      ++piece;
    } else {
      rows.push({ x, y, v, z: piece });
    }
  });
  return rows;
}

function isCoded(series) {
  return series.values !== undefined && series.mark !== "error_bars";
}

function dots(rows, series, look) {
  const colour = isCoded(series) ? "v" : look.colour;
  const paint = look.hollow ? { stroke: colour, strokeWidth: 1.5 } : { fill: colour };
  const rotate = series.symbol === "triangle_down" ? 180 : 0;
  return dot(rows, { x: "x", y: "y", r: look.size, symbol: look.symbol, rotate, ...paint, tip: rows.length < 400 });
}

function makeMarks(series, index, chart) {
  const rows = makeRows(series, chart);
  const look = makeLook(series, index);
  const stroke = {
    x: "x",
    y: "y",
    z: "z",
    stroke: look.colour,
    strokeWidth: look.width,
    strokeDasharray: look.dashed ? "6 4" : undefined,
  };
  const box = (half) => ({
    x1: (d) => d.x - half,
    x2: (d) => d.x + half,
    fill: look.colour,
    tip: rows.length < 400,
  });
  switch (series.mark) {
    case "line":
      return [line(rows, stroke)];
    case "steps":
      return [line(rows, { ...stroke, curve: "step-after" })];
    case "line_points":
      return [line(rows, stroke), dots(rows, series, look)];
    case "points":
      return [dots(rows, series, look)];
    case "error_bars":
      return [
        ruleY(rows, { y: "y", x1: (d) => d.x - d.v, x2: (d) => d.x + d.v, stroke: look.colour, strokeWidth: 1.5 }),
        dots(rows, series, look),
      ];
    case "bars":
      return [rect(rows, { ...box(0.4), y1: 0, y2: "y" })];
    case "squares":
      return [rect(rows, { ...box(0.48), y1: (d) => d.y - 0.48, y2: (d) => d.y + 0.48 })];
    case "polygons":
      return [line(rows, { x: "x", y: "y", z: "z", fill: "v", stroke: "none", curve: "linear-closed" })];
    default:
      throw new Error(`mark ${series.mark}`);
  }
}

// Whether the numbers span less than a decade, which is then not made a whole one.
function isNarrow(numbers) {
  const positive = numbers.filter((number) => number > 0);
  return positive.length > 0 && Math.max(...positive) < 10 * Math.min(...positive);
}

// About so many round numbers between the least and the most: a logarithmic axis of less than a
// decade would have one tick alone.
function roundNumbers(numbers, count) {
  const [least, most] = [Math.min(...numbers.filter((number) => number > 0)), Math.max(...numbers)];
  const power = 10 ** Math.floor(Math.log10((most - least) / count || least));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((each) => (most - least) / each <= count);
  const first = Math.ceil(least / step);
  return Array.from({ length: Math.floor(most / step) - first + 1 }, (_, i) => (first + i) * step);
}

// numbers: of the chart along this axis.
function axisOptions(axis, room, numbers) {
  const narrow = axis.log && isNarrow(axis.range ?? numbers);
  const options = { label: axis.label || null, type: axis.log ? "log" : "linear", nice: !axis.range && !narrow };
  if (axis.range) options.domain = axis.range;
  if (!axis.ticks) {
    if (axis.log) options.tickFormat = (value) => (narrow ? String(Number(value.toPrecision(2))) : decadeText(value));
    const count = Math.max(2, Math.round(room / 70));
    options.ticks = narrow ? roundNumbers(axis.range ?? numbers, count) : count;
    return options;
  }
  const names = new Map(axis.ticks);
  return { ...options, ticks: [...names.keys()], tickFormat: (value) => names.get(value) ?? "" };
}

// Powers of ten and what is between 0.001 and 1000 as they are.
function decadeText(value) {
  const power = Math.log10(value);
  const round = Math.abs(power - Math.round(power)) < 1e-9;
  if (value >= 1e-3 && value < 1e4) return round || /^[25]/.test(value.toExponential()) ? String(Number(value.toPrecision(3))) : "";
  return round ? `1e${Math.round(power)}` : "";
}

// Lines where the ticks are.
function gridOptions(axis) {
  return { strokeOpacity: 0.12, ...(axis.ticks ? { ticks: axis.ticks.map(([at]) => at) } : {}) };
}

function key(chart) {
  const entries = chart.series
    .map((series, index) => ({ series, look: makeLook(series, index) }))
    .filter(({ series }) => series.title && series.points.length);
  if (entries.length === 0) return [];
  const list = element("ul", { className: "key" });
  for (const { series, look } of entries) {
    const swatch = element("span", { className: `swatch ${series.mark}` });
    swatch.setAttribute("aria-hidden", "true");
    swatch.style.setProperty("--of", isCoded(series) ? "#21918c" : look.colour);
    if (look.dashed) swatch.classList.add("dashed");
    list.append(element("li", {}, swatch, series.title));
  }
  return [list];
}

function drawChart(chart, width) {
  const labels = (chart.labels ?? []).filter((label) => !label.in_picture);
  const wide = Math.max(...(chart.y.ticks ?? [[0, ""]]).map(([, name]) => name.length));
  const marginLeft = Math.min(Math.max(52, 14 + 7 * wide), 0.62 * width);
  const longest = Math.max(...(chart.x.ticks ?? [[0, ""]]).map(([, name]) => name.length));
  const across = (chart.x.ticks ?? []).length;
  const tilted = across * (7 * longest + 6) > width - marginLeft;
  const height = Math.max(240, Math.min(420, 0.66 * width)) + (tilted ? 5 * longest : 0);
  const coded = chart.series.some(isCoded);
  // Letters on a coloured square are dark in both schemes.
  const isOnSquare = ({ at: [x, y] }) =>
    chart.series.some((series) => series.mark === "squares" && series.points.some((point) => Math.abs(point[0] - x) < 0.5 && Math.abs(point[1] - y) < 0.5));
  const middle = labels.filter((label) => label.align === "centre");
  const onSquare = middle.filter(isOnSquare);
  const onGround = middle.filter((label) => !isOnSquare(label));
  const beside = labels.filter((label) => label.align !== "centre");
  const at = (options) => ({ x: (d) => d.at[0], y: (d) => d.at[1], text: "text", fill: "currentColor", ...options });
  const numbers = (i) => chart.series.flatMap((series) => series.points.map((point) => point[i]));
  const figure = plot({
    width,
    height,
    marginLeft,
    marginRight: 24,
    marginTop: 28, // between the label of y and its uppermost tick
    marginBottom: tilted ? Math.min(150, 24 + 5.4 * longest) : 42,
    style: { fontSize: "12px", background: "none", overflow: "visible" },
    ariaLabel: `${chart.title || "Chart"}: ${chart.y.label} against ${chart.x.label}`,
    x: { ...axisOptions(chart.x, width - marginLeft, numbers(0)), tickRotate: tilted ? -40 : 0 },
    y: axisOptions(chart.y, height, numbers(1)),
    color: coded
      ? { legend: true, marginLeft: 20, marginRight: 20, scheme: "viridis", label: chart.colour?.label, type: chart.colour?.log ? "log" : "linear" }
      : undefined,
    aspectRatio: chart.equal_units ? 1 : undefined,
    marks: [
      ...(chart.grid === false ? [] : [gridX(gridOptions(chart.x)), gridY(gridOptions(chart.y))]),
      ...chart.series.flatMap((series, index) => makeMarks(series, index, chart)),
      ...(onSquare.length ? [text(onSquare, at({ fill: "#111" }))] : []),
      ...(onGround.length ? [text(onGround, at({}))] : []),
      ...(beside.length ? [text(beside, at({ textAnchor: "start", dx: 6, stroke: "var(--ground)", strokeWidth: 4, className: "beside" }))] : []),
    ],
  });
  for (const svg of figure.tagName === "svg" ? [figure] : figure.querySelectorAll("svg")) {
    svg.setAttribute("role", "img");
    if (!svg.hasAttribute("aria-label")) svg.setAttribute("aria-label", `Colours: ${chart.colour?.label ?? ""}`);
    // A chart has one name; its groups have no role that could have one.
    for (const group of svg.querySelectorAll("g[aria-label]")) {
      group.dataset.part = group.getAttribute("aria-label");
      group.removeAttribute("aria-label");
    }
  }
  return figure;
}

// Labels beside points, once they are on the page: moved into the picture, and down from one another.
function settleLabels(svg) {
  const bounds = svg.getBoundingClientRect();
  const settled = [];
  const texts = [...svg.querySelectorAll(".beside text")];
  const top = (text) => text.getBoundingClientRect().top;
  for (const text of texts.sort((a, b) => top(a) - top(b))) {
    const box = text.getBoundingClientRect();
    const left = Math.min(0, bounds.right - box.right);
    let down = 0;
    for (const other of settled)
      if (box.left + left < other.right && other.left < box.right + left && box.top + down < other.bottom && other.top < box.bottom + down)
        down = other.bottom - box.top;
    if (left !== 0) text.setAttribute("x", left);
    if (down !== 0) text.setAttribute("y", down);
    settled.push(text.getBoundingClientRect());
  }
}

// Charts of a row may name their common ticks once; one below another, each needs the names.
function withNames(chart, charts) {
  const ticks = chart.y.ticks ?? [];
  if (ticks.length === 0 || ticks.some(([, name]) => name)) return chart;
  const named = charts.find(({ y }) => y.ticks?.length === ticks.length && y.ticks.some(([, name]) => name));
  return named ? { ...chart, y: { ...chart.y, ticks: named.y.ticks } } : chart;
}

const WIDEST = 880; // of a chart [px]

export function drawPicture(place, picture, width) {
  const columns = width < 640 ? 1 : Math.min(picture.columns, picture.charts.length);
  const gap = 20;
  const each = Math.min(WIDEST, Math.floor((width - gap * (columns - 1)) / columns));
  const grid = element("div", { className: "charts" });
  grid.style.gridTemplateColumns = `repeat(${columns}, minmax(0, 1fr))`;
  for (const described of picture.charts) {
    const chart = columns === 1 ? withNames(described, picture.charts) : described;
    const cell = element("div", { className: "chart" });
    if (chart.title) cell.append(element("p", { className: "title", textContent: chart.title }));
    if (chart.series.some((series) => series.points.length)) {
      cell.append(...key(chart), drawChart(chart, each));
    } else if (columns > 1) {
      cell.className = "empty";
    }
    const notes = (chart.labels ?? []).filter((label) => label.in_picture);
    if (notes.length) {
      const list = element("ul", { className: "notes" });
      for (const note of notes) list.append(element("li", { textContent: note.text }));
      cell.append(list);
    }
    grid.append(cell);
  }
  place.querySelector(".charts")?.remove();
  place.prepend(grid);
  for (const svg of grid.querySelectorAll("svg")) settleLabels(svg);
}
