// SPDX-License-Identifier: Apache-2.0
// Fills the places that drape_report has left in the page: charts and drapes. Texts and tables are
// in the page already. Attributes of the root element say what the script did, for tests:
// data-ready, data-charts, data-errors.
import { drawPicture } from "./charts.js";
import { showDrapes } from "./drapes.js";

const root = document.documentElement;
let errors = 0;
function reportError(error) {
  root.dataset.errors = String(++errors);
  console.error(error);
}
root.dataset.errors = "0";
window.addEventListener("error", (event) => reportError(event.message));

// One thing that cannot be shown must not hide the others.
function attempt(place, show) {
  try {
    show();
  } catch (error) {
    place.append(Object.assign(document.createElement("p"), {
      className: "missing",
      textContent: `Cannot be shown here: ${error.message}`,
    }));
    reportError(error);
  }
}

const data = JSON.parse(document.getElementById("data").textContent);
root.classList.add("scripted");

// Charts are drawn again when their place has another width, so that their letters keep their size.
const widths = new Map();
function drawAt(place) {
  const width = Math.round(place.clientWidth);
  if (width === 0 || width === widths.get(place)) return;
  widths.set(place, width);
  attempt(place, () => drawPicture(place, data.pictures[Number(place.dataset.picture)], width));
}
const charts = [...document.querySelectorAll("[data-picture]")];
const observer = new ResizeObserver((entries) => entries.forEach((entry) => drawAt(entry.target)));
for (const place of charts) {
  drawAt(place);
  observer.observe(place);
}
for (const place of document.querySelectorAll("[data-drapes]"))
  attempt(place, () => showDrapes(place, data.drapes[Number(place.dataset.drapes)], data.drapes));

root.dataset.charts = String(document.querySelectorAll("[data-picture] svg").length);
root.dataset.ready = "yes";
