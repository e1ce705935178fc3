#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Markdown has at most 100 columns, but for tables, code blocks, and lines that are one link or picture.
# usage: markdown_width.sh <source folder>
set -euo pipefail
export LC_ALL=C
cd "$1"

if ! files=$(git ls-files -co --exclude-standard -- '*.md' 2>/dev/null) || [ -z "$files" ]; then
  printf 'tests/repository/rules/markdown_width.sh: Skipped\nno git checkout here: no list of files\n'
  exit 77
fi
while IFS= read -r f; do [ ! -e "$f" ] || printf '%s\n' "$f"; done <<<"$files" | xargs -d '\n' awk '
  FNR == 1 { fenced = 0; blank = 1 }
  /^ *(```|~~~)/ { fenced = !fenced; next }
  # Four spaces after an empty line are a code block; else they continue a list or paragraph.
  /^    / && (blank || indented) { indented = 1; next }
  { blank = /^ *$/; indented = indented && blank }
  fenced || /^ *\|/ || /^ *<img / { next }
  {
    gsub(/[\200-\277]/, "")  # of a character in UTF-8, the first byte counts
    text = $0
    sub(/^ *([-*] |[0-9]+\. |> )?/, "", text)
    # One link, picture or path, with the punctuation after it.
    if (length($0) > 100 && text !~ /^!?\[[^]]*\]\([^)]*\)[.,;:]*$/ && text ~ / /) {
      print FILENAME ":" FNR ": " length($0) " columns, at most 100"
      bad = 1
    }
  }
  END { exit bad }' || exit 1
