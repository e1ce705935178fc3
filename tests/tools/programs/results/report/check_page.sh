#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Opens a page of drape_report from its file in headless Chromium: it is below 2 MB and has the parts
# that are named, all of them filled; drapes are drawn, without an error and without a request; dark
# on a desktop and light on a telephone, nothing is cut off, motions play in step and their GLB has
# all frames, and contrast and labels are as axe-core, the engine of Lighthouse, wants them. A page
# with certificates prints one sheet for each.
# A line for each fault; exit code 1 with faults, 77 where Chromium or axe-core is not installed.
# usage: check_page.sh report.html [part ...]
set -euo pipefail
here=$(dirname "$(realpath "$0")")
page=$(realpath "$1")
shift
Skip() {
  printf 'check_page.sh: Skipped\n%s\n' "$1"
  exit 77
}
browser=$(command -v chromium-headless-shell || command -v chromium) ||
  Skip 'neither chromium-headless-shell nor chromium is installed: no page is opened'
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
faults=$scratch/faults

# Open <file> <flag ...>: what the page has become is in "dom", the log of the browser in "log".
Open() {
  "$browser" --headless --no-sandbox --enable-unsafe-swiftshader --enable-logging=stderr --virtual-time-budget=20000 \
    --dump-dom "${@:2}" "file://$1" >"$scratch/dom" 2>"$scratch/log" || true
}
Count() { { grep -oE "$1" "$scratch/dom" || true; } | wc -l; }

megabytes=$(awk -v bytes="$(stat -c %s "$page")" 'BEGIN { printf "%.2f", bytes / 1e6 }')
awk -v size="$megabytes" 'BEGIN { exit size >= 2 }' || echo "$megabytes MB, expected less than 2" >>"$faults"
Open "$page" --window-size=1280,1000
for part in "$@"; do
  grep -q "<section id=\"$part\">" "$scratch/dom" || echo "no part $part" >>"$faults"
done
grep -q 'data-ready="yes"' "$scratch/dom" || echo 'the script of the page did not end' >>"$faults"
# Messages of the page itself; those of libraries on the speed of software rendering are no errors.
grep -E ':CONSOLE|Content Security Policy|Uncaught' "$scratch/log" |
  grep -v 'GPU stall due to ReadPixels' | sed 's/^/message of the browser: /' >>"$faults" || true
parts=$(Count '<section id=')
sheets=$(Count '<article class="certificate">')
if [ "$sheets" -gt 0 ]; then
  "$browser" --headless --no-sandbox --no-pdf-header-footer --print-to-pdf="$scratch/page.pdf" \
    "file://$page" >"$scratch/log" 2>&1 || true
  printed=$({ grep -aoE '/Type ?/Page\>' "$scratch/page.pdf" || true; } | wc -l)
  [ "$printed" = "$sheets" ] || echo "prints $printed pages, expected $sheets" >>"$faults"
fi
drapes=$(Count '<canvas ')
charts=$(Count '<figure class="chart">')

# The same page without its policy, which would refuse the script that looks for faults.
axe=$("$here/install_npm.sh")/axe-core/axe.min.js || true
if [ -f "$axe" ]; then
  {
    sed 's/<meta http-equiv="Content-Security-Policy"[^>]*>//' "$page"
    for script in "$axe" "$here/page_check.js"; do
      printf '<script>'
      cat "$script"
      printf '</script>\n'
    done
  } >"$scratch/open.html"
  # Dark on a desktop, light on a telephone.
  for scheme in 0 1; do
    Open "$scratch/open.html" --window-size=$([ $scheme = 0 ] && echo 1280 || echo 390),1000 \
      --blink-settings=preferredColorScheme=$scheme
    sed -n '/<pre id="found">/,/<\/pre>/p' "$scratch/dom" | sed -E 's/^.*<pre id="found">//; s/<\/pre>.*$//' \
      >"$scratch/found"
    {
      grep -qx checked "$scratch/found" || echo "the check did not end"
      grep -vx checked "$scratch/found" || true
    } >"$scratch/faults_of_scheme"
    sed "s/\$/ ($([ $scheme = 0 ] && echo dark || echo light))/" "$scratch/faults_of_scheme" >>"$faults"
  done
fi
if [ -s "$faults" ]; then
  sort -u "$faults"
  exit 1
fi
echo "$(basename "$page"): $parts parts, $charts charts, $drapes drapes to turn, $megabytes MB"
[ -f "$axe" ] || Skip 'npm cannot install axe-core: contrast and labels are not checked'
