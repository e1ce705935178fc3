#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# The product has at most so many lines: C++, CUDA, Python and JavaScript of our own, without tests.
# Work that needs more raises the limit in a commit of its own, which says what could not be replaced.
# usage: size_test.sh <source folder> [<limit>]
set -euo pipefail
limit=${2:-80093}
cd "$1"
git rev-parse -q --git-dir >/dev/null 2>&1 || {
  printf 'tests/repository/size_test.sh: Skipped\nno git checkout here: no list of files\n'
  exit 77
}
# Lines <folder ...>
Lines() {
  git ls-files -z -co --exclude-standard -- "$@" | grep -zE '\.(h|cc|cu|cuh|py|js)$' |
    xargs -0 cat 2>/dev/null | wc -l
}
folders=(physics cuda losses solver tools)
for folder in "${folders[@]}"; do
  printf '%7d  %s\n' "$(Lines "$folder")" "$folder"
done
total=$(Lines "${folders[@]}")
printf '%7d  of at most %d\n' "$total" "$limit"
[ "$total" -gt 0 ] || { echo "found no lines"; exit 1; }
[ "$total" -le "$limit" ] || { echo "the product has $((total - limit)) lines more than the limit"; exit 1; }
