// SPDX-License-Identifier: Apache-2.0
// Looks for what a reader could not see, read or reach in a page of drape_report. check_page.sh
// appends it, after axe-core, to a copy of the page without its policy; what it finds is in the element
// "found", a line each, and "checked" is the last line.
(async () => {
  const root = document.documentElement;
  const found = [];
  const name = (element) => `${element.tagName.toLowerCase()}.${element.getAttribute("class") ?? ""}`;

  function checkWidth() {
    if (root.scrollWidth <= window.innerWidth) return;
    for (const element of document.body.querySelectorAll("*"))
      if (element.getBoundingClientRect().right > window.innerWidth + 1 && !element.closest(".scroll, svg, .ramp"))
        found.push(`wider than the window: ${name(element)}: ${element.textContent.slice(0, 60)}`);
  }

  const buttonOf = (place, text) => [...place.querySelectorAll("button")].find((each) => each.textContent === text);
  const sleep = (time) => new Promise((resolve) => setTimeout(resolve, time));

  function readPixels(canvas) {
    const { width, height } = canvas;
    const context = new OffscreenCanvas(width, height).getContext("2d");
    context.drawImage(canvas, 0, 0);
    return new Uint32Array(context.getImageData(0, 0, width, height).data.buffer);
  }

  // Reads pixels, which takes time, until the work is done: the clock of the browser jumps over the
  // time in which nothing but files are read, and ends the check.
  async function finish(work, canvas) {
    let done = false;
    work.finally(() => (done = true)).catch(() => {});
    for (; !done; await sleep(10)) readPixels(canvas);
    await work;
  }

  // While one motion plays, all of them change their pixels, at the same time.
  async function checkMotion(places) {
    const canvases = places.map((place) => place.querySelector("canvas"));
    const changed = canvases.map(() => 0);
    let last = canvases.map(readPixels);
    const play = buttonOf(places[0], "play");
    play.click();
    for (let i = 0; i < 5; ++i) {
      await sleep(100);
      const now = canvases.map(readPixels);
      now.forEach((pixels, k) => {
        changed[k] = Math.max(changed[k], pixels.filter((pixel, j) => pixel !== last[k][j]).length);
      });
      last = now;
    }
    play.click();
    for (const count of changed)
      if (!(count > 1000)) found.push(`motion not played: ${count} pixels change`);
    const times = new Set(places.map((place) => place.querySelector("[type=range]").value));
    if (times.size > 1) found.push(`motions not in step: ${[...times]} s`);
  }

  // The model that a reader downloads has all frames of the page.
  async function checkModel(place, { times }) {
    const blob = await new Promise((resolve) => {
      URL.createObjectURL = (made) => (resolve(made), "blob:");
      buttonOf(place, "download GLB").click();
    });
    const length = new DataView(await blob.arrayBuffer()).getUint32(12, true);
    const model = JSON.parse(await blob.slice(20, 20 + length).text());
    const frames = [
      ...model.meshes.map((mesh) => mesh.primitives[0].targets.length + 1),
      ...model.animations[0].samplers.map((sampler) => model.accessors[sampler.input].count),
    ];
    if (frames.length !== 4 || frames.some((count) => count !== times.length))
      found.push(`model of ${times.length} frames has ${frames}`);
  }

  try {
    for (let wait = 0; root.dataset.ready !== "yes" && wait < 100; ++wait)
      await sleep(50);
    for (const details of document.querySelectorAll("details")) details.open = true;
    const result = await axe.run(document, {
      runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"],
      resultTypes: ["violations"],
    });
    for (const violation of result.violations)
      for (const node of violation.nodes)
        found.push(`${violation.id}: ${node.target}: ${[...node.any, ...node.all, ...node.none].map((each) => each.message).join("; ")}`);
    checkWidth();
    for (const section of document.querySelectorAll("main > section"))
      if (section.textContent.trim().length < 20) found.push(`empty part: ${section.id}`);
    for (const image of document.querySelectorAll("img"))
      if (image.naturalWidth === 0) found.push(`picture not shown: ${image.alt}`);
    for (const place of document.querySelectorAll("[data-drapes]")) {
      const canvas = place.querySelector("canvas");
      const drawn = canvas && readPixels(canvas).filter((pixel) => pixel > 0).length;
      if (!(drawn > 5000)) found.push(`drape not drawn: ${drawn} pixels`);
    }
    const places = [...document.querySelectorAll("[data-drapes]")].filter((place) => place.querySelector("[type=range]"));
    if (places.length > 0) await checkMotion(places);
    const { drapes } = JSON.parse(document.getElementById("data").textContent);
    for (const place of places)
      await finish(checkModel(place, drapes[place.dataset.drapes][place.dataset.first]), place.querySelector("canvas"));
    for (const element of document.querySelectorAll("[src], link[href], image")) {
      const address = element.getAttribute("src") ?? element.getAttribute("href");
      if (!/^(data|blob):/.test(address)) found.push(`request: ${address}`);
    }
  } catch (error) {
    found.push(`the check failed: ${error.stack}`);
  }
  document.body.append(Object.assign(document.createElement("pre"), {
    id: "found",
    textContent: [...new Set(found), "checked"].join("\n"),
  }));
})();
