// SPDX-License-Identifier: Apache-2.0
// Looks for what a reader could not see, read or reach in a page of drape_report. check_page.sh
// appends it, after axe-core, to a copy of the page without its policy; what it finds is in the element
// "found", a line each, and "checked" is the last line.
(async () => {
  const root = document.documentElement;
  const found = [];
  const name = (element) => `${element.tagName.toLowerCase()}.${element.getAttribute("class") ?? ""}`;

  function parseColour(text) {
    const numbers = (text.match(/[\d.]+/g) ?? []).map(Number);
    return numbers.length >= 3 && numbers[3] !== 0 ? numbers.slice(0, 3) : undefined;
  }
  function luminance(colour) {
    const [r, g, b] = colour.map((c) => (c / 255 <= 0.04045 ? c / 255 / 12.92 : ((c / 255 + 0.055) / 1.055) ** 2.4));
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  }
  function contrast(a, b) {
    const [dark, light] = [luminance(a), luminance(b)].sort((x, y) => x - y);
    return (light + 0.05) / (dark + 0.05);
  }
  function background(element) {
    for (let at = element; at; at = at.parentElement) {
      const colour = parseColour(getComputedStyle(at).backgroundColor);
      if (colour) return colour;
    }
    return [255, 255, 255];
  }

  // What axe leaves out: the letters of charts, which may also leave their picture or lie over one
  // another.
  function checkLetters(svg) {
    const box = svg.getBoundingClientRect();
    const ground = background(svg);
    const ticks = [];
    for (const text of svg.querySelectorAll("text")) {
      const place = text.getBoundingClientRect();
      if (!text.textContent.trim() || place.width === 0) continue;
      const fill = parseColour(getComputedStyle(text).fill);
      const onMark = text.closest("[fill='#111']"); // on a coloured square
      if (fill && !onMark && contrast(fill, ground) < 4.5)
        found.push(`letters of a chart: "${text.textContent}" has a contrast of ${contrast(fill, ground).toFixed(1)}`);
      if (place.left < box.left - 1 || place.right > box.right + 1 || place.top < box.top - 1 || place.bottom > box.bottom + 1)
        found.push(`letters of a chart: "${text.textContent}" leave ${svg.getAttribute("aria-label")}`);
      if (text.closest("[data-part$='axis tick label']")) ticks.push([text, place]);
    }
    for (const [i, [text, a]] of ticks.entries())
      for (const [other, b] of ticks.slice(i + 1)) {
        const tilted = /rotate\((?!0\))/.test(text.getAttribute("transform") ?? "");
        const apart = a.right < b.left || b.right < a.left || a.bottom < b.top + 1 || b.bottom < a.top + 1;
        if (!apart && !tilted)
          found.push(`letters of a chart: "${text.textContent}" lie over "${other.textContent}"`);
      }
  }

  function checkWidth() {
    if (root.scrollWidth <= window.innerWidth) return;
    for (const element of document.body.querySelectorAll("*"))
      if (element.getBoundingClientRect().right > window.innerWidth + 1 && !element.closest(".scroll, svg, .ramp"))
        found.push(`wider than the window: ${name(element)}: ${element.textContent.slice(0, 60)}`);
  }

  try {
    for (let wait = 0; root.dataset.ready !== "yes" && wait < 100; ++wait)
      await new Promise((resolve) => setTimeout(resolve, 50));
    for (const details of document.querySelectorAll("details")) details.open = true;
    const result = await axe.run(document, {
      runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "best-practice"],
      resultTypes: ["violations"],
    });
    for (const violation of result.violations)
      for (const node of violation.nodes)
        found.push(`${violation.id}: ${node.target}: ${[...node.any, ...node.all, ...node.none].map((each) => each.message).join("; ")}`);
    document.querySelectorAll("figure[data-picture] svg").forEach(checkLetters);
    checkWidth();
    for (const section of document.querySelectorAll("main > section"))
      if (section.textContent.trim().length < 20) found.push(`empty part: ${section.id}`);
    for (const image of document.querySelectorAll("img"))
      if (image.naturalWidth === 0) found.push(`picture not shown: ${image.alt}`);
    for (const place of document.querySelectorAll("[data-drapes]")) {
      const drawn = place.querySelector("canvas")?.dataset.drawn;
      if (!(Number(drawn) > 5000)) found.push(`drape not drawn: ${drawn} pixels`);
    }
    for (const place of document.querySelectorAll("[data-picture]"))
      if (!place.querySelector("svg, .notes")) found.push(`chart not drawn: ${place.textContent}`);
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
