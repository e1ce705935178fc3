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
    checkWidth();
    for (const section of document.querySelectorAll("main > section"))
      if (section.textContent.trim().length < 20) found.push(`empty part: ${section.id}`);
    for (const image of document.querySelectorAll("img"))
      if (image.naturalWidth === 0) found.push(`picture not shown: ${image.alt}`);
    for (const place of document.querySelectorAll("[data-drapes]")) {
      const drawn = place.querySelector("canvas")?.dataset.drawn;
      if (!(Number(drawn) > 5000)) found.push(`drape not drawn: ${drawn} pixels`);
    }
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
