#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# clang-tidy, with .clang-tidy's checks as errors, on the C++ sources that differ from a base, and on
# those whose own header differs; tests apart. Slow: seconds per file.
# usage: tidy.sh <source folder> <build folder> [<base commit> | <file>...]
#   without a base or files: the sources that the last commit changed
#   DRAPE_TIDY_MAX=n: at most n files, those with most changed lines first; says what it leaves out
set -euo pipefail
version=14
build=$(realpath "$2")
cd "$1"
shift 2

tool=
for candidate in "clang-tidy-$version" clang-tidy; do
  if "$candidate" --version 2>/dev/null | grep -q "version $version\."; then tool=$candidate; break; fi
done
if [ -z "$tool" ] || [ ! -e "$build/compile_commands.json" ]; then
  echo "tests/repository/rules/tidy.sh: Skipped"
  echo "no clang-tidy $version or no $build/compile_commands.json here"
  exit 77
fi

# The sources to look at, one a line.
if [ $# -gt 0 ] && [ -f "$1" ]; then
  files=$(printf '%s\n' "$@")
else
  base=${1:-HEAD~1}
  files=$(git diff --numstat -M --diff-filter=d "$base" -- '*.h' '*.cc' ':!tests' | sort -rn | cut -f3 |
          sed -E 's/\{[^}]* => ([^}]*)\}/\1/; s#//#/#g; s/.* => //' |
          while IFS= read -r f; do f=${f%.h}; f=${f%.cc}.cc; [ ! -f "$f" ] || echo "$f"; done | awk '!seen[$0]++')
fi
if [ -n "${DRAPE_TIDY_MAX:-}" ]; then
  all=$(grep -c . <<<"$files" || true)
  files=$(head -n "$DRAPE_TIDY_MAX" <<<"$files")
  if [ "$all" -gt "$DRAPE_TIDY_MAX" ]; then echo "tidy.sh: $DRAPE_TIDY_MAX of $all changed sources"; fi
fi
if [ -z "$files" ]; then exit 0; fi

# Clang cannot read GCC's precompiled headers, and does not know all of its warnings.
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
sed -E 's/ -include [^ ]*cmake_pch\.hxx//; s/ (-fpch-preprocess|-Winvalid-pch|-Wno-(restrict|stringop-[a-z]*))//g' \
  "$build/compile_commands.json" >"$scratch/compile_commands.json"

status=0
while IFS= read -r f; do
  if grep -q "\"[^\"]*/$f\"" "$scratch/compile_commands.json"; then printf '%s\0' "$f"; fi
done <<<"$files" |
  { xargs -0 -n 1 -P "$(nproc)" "$tool" --quiet --warnings-as-errors='*' -p "$scratch" 2>/dev/null || true; } |
  sed -E "s#^$PWD/##" | { grep -E '^[^ ]+:[0-9]+:[0-9]+: (error|warning): ' || true; } |
  sed -E 's/:[0-9]+: (error|warning): /: /; s/,-warnings-as-errors\]/]/' | sort -u |
  awk '{ print; bad = 1 } END { exit bad }' || status=1
exit $status
