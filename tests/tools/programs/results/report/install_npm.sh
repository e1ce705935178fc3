#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Prints the folder node_modules of the page of drape_report. npm installs it once for all tests of a
# checkout: build/npm has a folder for each package-lock.json. Ends with exit code 1 where npm cannot.
set -euo pipefail
root=$(realpath "$(dirname "$(realpath "$0")")/../../../../..")
sources=$root/tools/programs/results/report/page
lock=$(sha256sum "$sources/package-lock.json" | cut -c1-16)
made=$root/build/npm/$lock
if [ ! -d "$made" ]; then
  mkdir -p "$root/build/npm"
  scratch=$(mktemp -d "$root/build/npm/new_XXXXXX")
  trap 'rm -rf "$scratch"' EXIT
  cp "$sources"/package*.json "$scratch"
  (cd "$scratch" && npm ci --ignore-scripts --no-audit --no-fund >npm.log 2>&1) || exit 1
  mv -T "$scratch" "$made" 2>/dev/null || true # another test may have been first
fi
printf '%s\n' "$made/node_modules"
