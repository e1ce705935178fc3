#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Sources are as clang-format leaves them; other versions of it give other results, so one is pinned.
# usage: format.sh <source folder> [--fix]
set -euo pipefail
version=14
cd "$1"

tool=
for candidate in "clang-format-$version" clang-format; do
  if "$candidate" --version 2>/dev/null | grep -q "version $version\."; then tool=$candidate; break; fi
done
if [ -z "$tool" ]; then
  echo "tests/repository/rules/format.sh: Skipped"
  echo "no clang-format $version here (found: $(clang-format --version 2>/dev/null || echo none)); Debian 12 has it"
  exit 77
fi
if ! git rev-parse 2>/dev/null; then
  printf 'tests/repository/rules/format.sh: Skipped\nno git checkout here: no list of files\n'
  exit 77
fi
how=(--dry-run -Werror)
if [ "${2:-}" = --fix ]; then how=(-i); fi

status=0
git ls-files -coz --exclude-standard -- '*.h' '*.cc' '*.cu' '*.cuh' |
  while IFS= read -rd '' f; do [ ! -e "$f" ] || printf '%s\0' "$f"; done |
  xargs -0 -n 16 -P "$(nproc)" "$tool" --style=file "${how[@]}" 2>&1 |
  sed -nE 's/^([^ ]+):([0-9]+):[0-9]+: error: code should be clang-formatted.*/\1:\2: not formatted/p' |
  awk -F: '!seen[$1]++ { print; bad = 1 } END { exit bad }' || status=1
if [ $status = 1 ]; then echo "Format with: tests/repository/rules/format.sh . --fix"; fi
exit $status
