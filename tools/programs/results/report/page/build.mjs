// SPDX-License-Identifier: Apache-2.0
// Bundles the script, the style and the licences of what is bundled into one template:
//   npm ci --ignore-scripts && node build.mjs [file to write]
import { createHash } from "node:crypto";
import { existsSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
process.chdir(here);

const bundled = await build({
  entryPoints: ["page.js"],
  bundle: true,
  format: "iife",
  minify: true,
  target: "es2022",
  charset: "utf8",
  legalComments: "none", // the licences are in the footer, in full
  metafile: true,
  write: false,
});
const script = bundled.outputFiles[0].text.trimEnd();
const style = (
  await build({ entryPoints: ["style.css"], minify: true, charset: "utf8", write: false })
).outputFiles[0].text.trimEnd();

function escapeHtml(text) {
  return text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;");
}

// The packages of the files that are in the bundle, with their licences; one text for many.
function collectLicences(inputs) {
  const folders = new Set();
  for (const path of Object.keys(inputs)) {
    const match = path.match(/^(.*node_modules\/(?:@[^/]+\/)?[^/]+)\//);
    if (match) folders.add(match[1]);
  }
  const packagesOfText = new Map();
  for (const folder of [...folders].sort()) {
    const { name, version, license } = JSON.parse(readFileSync(join(folder, "package.json")));
    const file = readdirSync(folder).find((entry) => /^licen[cs]e/i.test(entry));
    if (!file) throw new Error(`${folder}: no licence file`);
    const text = readFileSync(join(folder, file), "utf8").trim();
    const entry = `${name} ${version} (${license})`;
    packagesOfText.set(text, [...(packagesOfText.get(text) ?? []), entry]);
  }
  return [...packagesOfText]
    .map(([text, names]) => `<h3>${escapeHtml(names.join(", "))}</h3><pre>${escapeHtml(text)}</pre>`)
    .join("\n");
}

const parts = {
  HASH: createHash("sha256").update(script).digest("base64"),
  STYLE: style,
  LICENCES: collectLicences(bundled.metafile.inputs),
  SCRIPT: script,
};
const layout = readFileSync("layout.html", "utf8");
const template = layout.replace(/@@([A-Z]+)@@/g, (_, name) => parts[name]);
for (const marker of ["%%TITLE%%", "%%BODY%%", "%%DATA%%"])
  if (template.split(marker).length !== 2) throw new Error(`layout.html: expected one ${marker}`);
const target = process.argv[2] ?? "template.html";
const known = existsSync(target) ? readFileSync(target, "utf8") : "";
writeFileSync(target, template);
console.log(`${target}: ${Math.round(Buffer.byteLength(template) / 1024)} KiB`,
            template === known ? "(unchanged)" : "");
