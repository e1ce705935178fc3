#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The committed template of drape_report is what its sources and the locked packages make.
# usage: page_test.sh <source folder>
set -euo pipefail
here=$(dirname "$(realpath "$0")")
page=$(realpath "$1")/tools/programs/results/report/page
Skip() {
  printf 'tests/repository/page_test.sh: Skipped\n%s\n' "$1"
  exit 77
}
command -v npm >/dev/null || Skip 'npm is not installed'
copy=$(mktemp -d)
trap 'rm -rf "$copy"' EXIT
cp "$page"/*.{json,mjs,js,css,html} "$copy"
cd "$copy"
modules=$(timeout 100 "$here/../tools/programs/results/report/install_npm.sh") ||
  Skip 'npm cannot install the packages of package-lock.json: no registry here?'
ln -s "$modules" node_modules
node build.mjs built.html
cmp built.html "$page/template.html" || {
  echo "template.html is not what its sources make: run 'npm ci --ignore-scripts && npm run build' there"
  exit 1
}
