// SPDX-License-Identifier: Apache-2.0
// Shows the drapes of the page. Texts, tables and charts are in the page already. Attributes of the
// root element say what the script did, for tests: data-ready, data-errors.
import { showDrapes } from "./drapes.js";

const root = document.documentElement;
let errors = 0;
function reportError(error) {
  root.dataset.errors = String(++errors);
  console.error(error);
}
root.dataset.errors = "0";
window.addEventListener("error", (event) => reportError(event.message));

const { drapes, bodies } = JSON.parse(document.getElementById("data").textContent);
for (const group of drapes)
  for (const drape of group) Object.assign(drape, { faces: drape.faces ?? group[0].faces, body: bodies[drape.body] });
root.classList.add("scripted");

// A drape that cannot be shown does not hide the others.
for (const place of document.querySelectorAll("[data-drapes]")) {
  try {
    showDrapes(place, drapes[Number(place.dataset.drapes)], drapes);
  } catch (error) {
    place.append(Object.assign(document.createElement("p"), {
      className: "missing",
      textContent: `Cannot be shown here: ${error.message}`,
    }));
    reportError(error);
  }
}
root.dataset.ready = "yes";
