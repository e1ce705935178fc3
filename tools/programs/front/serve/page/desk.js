// SPDX-License-Identifier: Apache-2.0
// The desk: it asks the server for what has changed, shows it, and tells it what the user wants.
import { Picture, svgNode } from "./picture.js";

const $ = (id) => document.getElementById(id);
const KEPT = ["fabric", "mass", "sample", "warp", "diameter", "support", "customer", "operator", "date"];
const items = new Map(); // by id
const nodes = new Map(); // of the list and the jobs, by id
const ticked = new Set(); // ids
let version = 0;
let opened; // id of the photograph in the editor
let shown; // id of the item whose command is shown
let busyUntil = 0; // until then the server is asked often [ms]
let timer = 0; // of the next question
let lost = false;

const node = (tag, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
};

const say = (text, bad = false) => Object.assign($("status"), { textContent: text, className: bad ? "bad" : "" });

async function post(path, body) {
  busyUntil = Date.now() + 5000;
  const response = await fetch(path, { method: "POST", body });
  const answer = await response.json().catch(() => ({ error: `status ${response.status}` }));
  if (!response.ok) throw new Error(answer.error);
  return answer;
}

// Does what a user wants; an error is one line.
async function act(work) {
  try {
    const answer = await work();
    await watch();
    return answer;
  } catch (error) {
    say(error.message, true);
  }
}

// Photographs: from the user to the server.

const change = (id, fields) => post(`change/${id}`, JSON.stringify(fields));

// The rows of a samples.csv by the names of their files.
function readTable(text) {
  const separator = /^[^\n]*;/.test(text) ? ";" : ",";
  const rows = text.replace(/^\ufeff/, "").split(/\r?\n/).filter((line) => line.trim());
  const cells = rows.map((row) =>
    [...`${separator}${row}`.matchAll(new RegExp(`${separator}("((?:[^"]|"")*)"|[^${separator}]*)`, "g"))].map((found) =>
      (found[2] ?? found[1]).replaceAll('""', '"').trim()));
  const names = cells.shift() ?? [];
  const known = new Set([...$("fields").elements].map((input) => input.name).filter(Boolean));
  return new Map(cells.map((row) => {
    const fields = Object.fromEntries(names.map((name, i) => [name, row[i] ?? ""]));
    const kept = Object.entries(fields).filter(([name, value]) => known.has(name) && value);
    return [(fields.file ?? "").split("/").pop(), Object.fromEntries(kept)];
  }));
}

async function addFiles(files) {
  const table = [...files].find((file) => file.name.endsWith(".csv"));
  const rows = table ? readTable(await table.text()) : new Map();
  const before = items.get(opened)?.fields ?? {};
  const pictures = [...files].filter((file) => !file.name.startsWith(".") && file !== table)
    .sort((a, b) => a.name.localeCompare(b.name, "en", { numeric: true }));
  const added = [];
  let whole = 0;
  for (const [i, file] of pictures.entries()) {
    say(`Sends ${file.name}, ${i + 1} of ${pictures.length}`);
    whole += await act(async () => {
      const { id } = await post(`upload?name=${encodeURIComponent(file.name)}`, file);
      const folder = file.webkitRelativePath?.split("/").slice(1, -1).pop();
      const given = rows.get(file.name) ?? {};
      const kept = KEPT.filter((key) => before[key]).map((key) => [key, before[key]]);
      const fields = { ...Object.fromEntries(kept), ...(folder && { fabric: folder }), ...given };
      ticked.add(id);
      added.push(id);
      if (Object.keys(fields).length) await change(id, fields);
      return 1;
    }) ?? 0;
  }
  if (whole === pictures.length) say(`${added.length} of ${pictures.length} photographs added.`);
  if (added.length) open(added[0]);
}

// The files of a folder that was dropped, too.
async function filesOf(entry) {
  if (entry.isFile) return [await new Promise((resolve, reject) => entry.file(resolve, reject))];
  const reader = entry.createReader();
  const files = [];
  for (;;) {
    const entries = await new Promise((resolve, reject) => reader.readEntries(resolve, reject));
    if (!entries.length) return files;
    for (const each of entries) files.push(...(await filesOf(each)));
  }
}

// Photographs: shown.

const stateText = { queued: "waits", running: "runs", done: "done", failed: "failed", cancelled: "cancelled" };
const names = ({ fields }) =>
  [fields.fabric, fields.sample && `sample ${fields.sample}`, fields.specimen && `specimen ${fields.specimen}`,
    fields.face && `face ${fields.face}`].filter(Boolean).join(", ");
const percent = ({ dc, dc_sd }) => `${(100 * dc).toFixed(1)} ± ${(100 * dc_sd).toFixed(1)} %`;

function pictureRow(id) {
  const tick = node("input", { type: "checkbox" });
  const button = node("button", { type: "button" });
  const result = node("span");
  tick.addEventListener("change", () => {
    if (tick.checked) ticked.add(id);
    else ticked.delete(id);
    showFit();
  });
  button.addEventListener("click", () => open(id, true));
  const row = node("li", {}, node("label", {}, tick), button, result);
  $("list").append(row);
  return {
    row,
    update(item) {
      const name = [item.name, names(item)].filter(Boolean).join(": ");
      tick.checked = ticked.has(id);
      tick.ariaLabel = `Tick ${name}`;
      button.textContent = name;
      button.setAttribute("aria-current", id === opened);
      result.textContent = item.state === "done" ? percent(item.result) : stateText[item.state];
      result.className = item.state === "failed" ? "bad" : "";
    },
  };
}

const picture = new Picture($("picture"), (fields) => changeOpened(fields), () =>
  document.querySelector("[name=adds]:checked").value);

async function changeOpened(fields) {
  const ids = $("also").checked && !("cloth_points" in fields || "ground_points" in fields)
    ? new Set([opened, ...ticked]) : [opened];
  await act(async () => {
    for (const id of ids) await change(id, fields);
  });
  picture.settle(fields);
}

function open(id, move = false) {
  picture.flush();
  const last = opened;
  opened = shown = id;
  picture.settle();
  $("editor").hidden = false;
  for (const each of [last, id]) if (items.has(each)) nodes.get(each).update(items.get(each));
  showEditor(true);
  if (move) $("h_editor").focus();
}

function showEditor(all = false) {
  const item = items.get(opened);
  if (!item) return;
  $("h_editor").textContent = item.name;
  const { result, warnings = result?.warnings ?? [] } = item;
  const text = {
    done: () => `Drape coefficient ${percent(result)}, ${result.folds} nodes; ${result.bending_length || "bending length not known"}.`,
    failed: () => item.error.replace(/^drape_photo: error: (\S*\/picture\.\w+: )?/, "Not measured: "),
  }[item.state]?.() ?? `The measurement ${stateText[item.state]}.`;
  const notes = item.state === "done" ? warnings.map((warning) => ` Note: ${warning}.`).join("") : "";
  if ($("result").textContent !== text + notes) $("result").textContent = text + notes;
  for (const input of $("fields").elements)
    if (input.name && (all || document.activeElement !== input)) input.value = item.fields[input.name] ?? "";
  picture.show(item, `file/${opened}`);
  showCommand();
}

// Jobs.

const run = (wanted) => act(async () => {
  shown = (await post("run", JSON.stringify(wanted))).id;
  say("Queued; its command is below.");
});

// Lets a button remove items: its first press asks, and the next one removes them, if the focus has
// not moved in between. what(): their name; ids(): theirs.
function letRemove(button, what, ids) {
  let asked;
  const ask = (now) => {
    asked = now;
    button.textContent = asked ? `Delete ${what()} for good` : "Remove";
  };
  ask(false);
  button.addEventListener("blur", () => ask(false));
  button.addEventListener("click", () => {
    if (!asked) return ask(true);
    const name = what();
    act(async () => {
      for (const id of ids()) await post(`remove/${id}`, "");
      say(`${name} deleted.`);
      button.closest("section").querySelector("h2").focus();
    });
  });
  return button;
}

const tickedPictures = () => [...ticked].map((id) => items.get(id)).filter((item) => item?.kind === "picture");

function showFit() {
  const pictures = tickedPictures();
  const fabrics = [...new Set(pictures.map((item) => item.fields.fabric ?? ""))];
  const count = `${pictures.length} photograph${pictures.length === 1 ? "" : "s"}`;
  $("fit").disabled = $("remove").disabled = pictures.length === 0;
  $("fit").textContent = fabrics.length > 1 ? `Compare ${fabrics.join(" and ")} (${count})` : `Fit ${count}`;
  $("tick").textContent = pictures.length ? "Tick none" : "Tick all";
  for (const fabric of fabrics)
    if (fabrics.length > 1 && !fabric) return "give the fabric of each ticked photograph";
    else if (!pictures.some((item) => (item.fields.fabric ?? "") === fabric && item.fields.mass))
      return `give the mass${fabric && ` of ${fabric}`} in g/m², as weighed`;
  return "";
}

// The outline of a photograph and that of its fit so far.
function outlineFigure({ name, image_px: measured, fit_px: fitted }) {
  const turn = (i) => (2 * Math.PI * i) / measured.length;
  const path = (radii, kind) =>
    svgNode("path", { class: kind, d: `M${radii.map((r, i) => [r * Math.cos(turn(i)), -r * Math.sin(turn(i))]).join("L")}Z` });
  const most = 1.05 * Math.max(...measured, ...fitted);
  const text = `${items.get(name)?.name ?? name}: measured in blue, fitted so far in red`;
  return node("figure", { className: "photo" },
    svgNode("svg", { viewBox: [-most, -most, 2 * most, 2 * most].join(" "), role: "img", "aria-label": `Outlines of ${text}` },
      path(measured, "image"), path(fitted, "fitted")), node("figcaption", { textContent: text }));
}

function jobCard(id) {
  const [title, state, error, buttons] = [node("h3"), node("p"), node("p", { className: "bad" }), node("p", { className: "tools" })];
  const progress = node("progress", { max: 100 });
  const tail = node("pre", { tabIndex: 0 });
  const log = node("details", {}, node("summary", { textContent: "What the programs say" }), tail);
  const page = node("div"), outlines = node("div", { className: "grid" });
  const card = node("article", { className: "card" }, title, state, progress, outlines, error, buttons, page, log);
  $("jobs").prepend(card);
  let before = "", drawn = "";
  const button = (text, work) => {
    const made = node("button", { type: "button", textContent: text });
    made.addEventListener("click", () => {
      shown = id;
      work();
    });
    return made;
  };
  return {
    row: card,
    update(item) {
      const kind = { fit: "Fit", export: "Export", garment: "Garment preview" }[item.kind];
      title.textContent = `${kind} ${/^fit_(.*)/.exec(item.fit ?? "")?.[1] ?? item.name}`;
      const lines = (item.tail ?? "").trimEnd().split("\n");
      const found = lines.map((line) => /^(\w+) +(\d+) %/.exec(line)).filter(Boolean).pop();
      const once = lines.find((line) => line.includes(" at once: "))?.split(" at once: ")[1];
      state.textContent = item.state === "running"
        ? [lines.at(-1) || "begins", once].filter(Boolean).join("; at once: ") : stateText[item.state];
      progress.hidden = item.state !== "running";
      progress.ariaLabel = `Progress of ${title.textContent}`;
      if (found) progress.value = Number(found[2]);
      const drapes = item.outlines ?? [];
      if (drawn !== (drawn = JSON.stringify(drapes))) outlines.replaceChildren(...drapes.map(outlineFigure));
      error.textContent = item.error ?? "";
      tail.ariaLabel = `Output of ${title.textContent}`;
      if (item.tail) tail.textContent = item.tail;
      log.hidden = !tail.textContent;
      if (before === item.state) return;
      if (before) say(`${title.textContent}: ${stateText[item.state]}.`, item.state === "failed");
      before = item.state;
      const active = item.state === "queued" || item.state === "running";
      const { fits = [], files = [], page: report } = item.result ?? {};
      buttons.replaceChildren(
        ...(active ? [button("Cancel", () => act(() => post(`cancel/${id}`, "")))] : []),
        ...(item.state === "failed" || item.state === "cancelled"
          ? [button("Continue", () => act(() => post(`retry/${id}`, "")))] : []),
        ...fits.flatMap((fit) => {
          const of = fits.length > 1 ? ` ${fit.replace(/^fit_/, "")}` : "";
          return [button(`Export${of}`, () => run({ kind: "export", of: id, fit })),
            button(`Dress${of}`, () => run({ kind: "garment", of: id, fit }))];
        }),
        button("Command", () => showCommand(true)),
        ...(active ? [] : [letRemove(node("button", { type: "button" }), () => title.textContent, () => [id])]),
      );
      const links = item.kind === "export" ? files.filter((name) => /^result\/[^/]+$/.test(name)) : [];
      page.replaceChildren(
        ...(report ? [node("p", {}, node("a", { href: `file/${id}/${report}`, target: "_blank", textContent: "Open the page of results" })),
          node("iframe", { src: `file/${id}/${report}`, title: `Results of ${title.textContent}` })] : []),
        ...(links.length ? [node("ul", {}, ...links.map((name) =>
          node("li", {}, node("a", { href: `file/${id}/${name}`, download: name.slice(7), textContent: name.slice(7) }))))] : []),
      );
    },
  };
}

function showCommand(move = false) {
  const text = items.get(shown)?.command ?? "drapefit serve";
  if ($("command").textContent !== text) $("command").textContent = text;
  if (move) $("command").focus();
}

// The server.

async function ask() {
  const response = await fetch(`state?since=${version}`);
  if (!response.ok) throw new Error("This address is of an earlier desk; open the one that drape_serve has printed.");
  const news = await response.json();
  version = news.version;
  for (const id of news.removed) {
    nodes.get(id)?.row.remove();
    for (const each of [items, nodes, ticked]) each.delete(id);
    if (opened === id) $("editor").hidden = true;
  }
  for (const item of news.items) {
    items.set(item.id, item);
    if (!nodes.has(item.id)) nodes.set(item.id, item.kind === "picture" ? pictureRow(item.id) : jobCard(item.id));
    nodes.get(item.id).update(item);
    if (item.kind === "picture" && /running|queued/.test(item.state)) busyUntil = Math.max(busyUntil, Date.now() + 1000);
  }
  if (news.items.length || news.removed.length) {
    const count = [...items.values()].filter((item) => item.kind === "picture").length;
    $("no_jobs").hidden = items.size > count;
    if (lost || $("status").textContent === "No photographs yet.") say(`${count} photographs on the desk.`);
    showFit();
    if (news.items.some((item) => item.id === opened)) showEditor();
    showCommand();
  }
  lost = false;
}

// Asks now, and again when something can have changed: soon while the user waits for it.
async function watch() {
  clearTimeout(timer);
  try {
    await ask();
  } catch (error) {
    lost = true;
    say(error instanceof TypeError ? "The desk does not answer: is drape_serve running?" : error.message, true);
  }
  clearTimeout(timer);
  timer = setTimeout(watch, Date.now() < busyUntil ? 60 : 500);
}

for (const id of ["files", "folder"])
  $(id).addEventListener("change", async ({ target }) => {
    await addFiles(target.files);
    target.value = "";
  });
for (const type of ["dragover", "dragleave", "drop"])
  document.addEventListener(type, (event) => {
    event.preventDefault();
    $("drop").classList.toggle("over", type === "dragover");
  });
document.addEventListener("drop", async ({ dataTransfer }) => {
  const entries = [...dataTransfer.items].map((item) => item.webkitGetAsEntry()).filter(Boolean);
  addFiles((await Promise.all(entries.map(filesOf))).flat());
});
$("fields").addEventListener("submit", (event) => event.preventDefault());
$("fields").addEventListener("change", ({ target }) => {
  if (!target.name) return;
  const isNumber = target.inputMode === "decimal";
  changeOpened({ [target.name]: isNumber ? target.value.trim().replace(",", ".") : target.value.trim() });
});
$("clear").addEventListener("click", () => changeOpened({ cloth_points: "", ground_points: "" }));
$("tick").addEventListener("click", () => {
  const all = tickedPictures().length === 0;
  for (const [id, item] of items) if (item.kind === "picture" && all) ticked.add(id);
  if (!all) ticked.clear();
  for (const [id, item] of items) if (item.kind === "picture") nodes.get(id).update(item);
  showFit();
});
letRemove($("remove"), () => `${tickedPictures().length} photographs`, () => tickedPictures().map((item) => item.id));
$("fit").addEventListener("click", () => {
  const missing = showFit();
  if (missing) say(`Please ${missing}.`, true);
  else run({ kind: "fit", pictures: tickedPictures().map((item) => item.id) });
});
watch();
