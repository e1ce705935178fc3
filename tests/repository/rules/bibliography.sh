#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# What a comment or document cites is in the repository:
#   [Gong 2024, eq. 12]           an entry "- **[Gong 2024]**" of physics/MODEL.md or solver/METHODS.md
#   [MODEL, M3], [METHODS, P4]    a formula or step marked "**(M3)**" there
# and nothing refers to documents that are not ("SPEC section 5", "fact 7", "the paper").
# usage: bibliography.sh <source folder>
set -euo pipefail
export LC_ALL=C
cd "$1"

if ! files=$(git ls-files -co --exclude-standard 2>/dev/null) || [ -z "$files" ]; then
  printf 'tests/repository/rules/bibliography.sh: Skipped\nno git checkout here: no list of files\n'
  exit 77
fi
files=$(grep -E '\.(h|cuh|cc|cu|in|md|txt|json|sh)$' <<<"$files" | grep -vE '^tests/repository/' |
        while IFS= read -r f; do [ ! -e "$f" ] || printf '%s\n' "$f"; done)
documents=
for document in physics/MODEL.md solver/METHODS.md; do
  if [ -e "$document" ]; then documents="$documents $document"; else echo "$document: not found"; fi
done

# shellcheck disable=SC2086
xargs -d '\n' awk -v documents="$documents" '
  function Report(what) { print FILENAME ":" FNR ": " what; bad = 1 }
  # The keys of one bracket: "Gong 2024, eq. 12; Li 2020" or "MODEL, M3, M4".
  function CheckKeys(inside,   n, i, part, key, m, j, mark) {
    n = split(inside, part, /; */)
    for (i = 1; i <= n; ++i) {
      if (part[i] ~ /^(MODEL|METHODS)(,|$)/) {
        m = split(part[i], mark, /, *| and |–/)
        key = mark[1] == "MODEL" ? "physics/MODEL.md" : "solver/METHODS.md"
        if (m == 1) Report("[" inside "]: expected an anchor, as [" mark[1] ", M3]")
        for (j = 2; j <= m; ++j)
          if (!((key, mark[j]) in anchor)) Report("[" inside "]: " key " has no **(" mark[j] ")**")
      } else if (match(part[i], /^[A-Z][^,;]* (19|20)[0-9][0-9][a-z]?/)) {
        key = substr(part[i], 1, RLENGTH)
        if (!(key in entry)) Report("[" inside "]: no entry \"- **[" key "]**\" in" documents)
      }
    }
  }
  BEGIN {
    n = split(documents, document, " ")
    for (i = 1; i <= n; ++i)
      for (FNR = 1; (getline line < document[i]) > 0; ++FNR) {
        FILENAME = document[i]
        if (match(line, /^- \*\*\[[^]]*\]\*\*/)) {
          key = substr(line, 6, RLENGTH - 8)
          if (key in entry) Report("a second entry [" key "]")
          entry[key] = 1
        }
        while (match(line, /\*\*\([A-Z]+[0-9]+[a-z]?\)\*\*/)) {
          key = substr(line, RSTART + 3, RLENGTH - 6)
          if ((document[i], key) in anchor) Report("a second anchor (" key ")")
          anchor[document[i], key] = 1
          line = substr(line, RSTART + RLENGTH)
        }
      }
    bad += n < 2
  }
  FNR == 1 { rest = "" }
  {
    line = $0
    if (line ~ /(^|[^A-Za-z_])SPEC([^A-Za-z_]|$)/) Report("\"SPEC\" is not in the repository: cite physics/MODEL.md or solver/METHODS.md")
    if (line ~ /(^|[^A-Za-z])[Ff]acts? [0-9]/) Report("\"fact\" with a number: cite [MODEL, M…]")
    if (line ~ /(^|[^A-Za-z])[Tt]he (paper|article|publication)([^A-Za-z]|$)/) Report("\"the paper\": cite its key, as [Gong 2024]")
    # A key may be broken over two comment lines.
    if (rest != "") { sub(/^[ \t]*(\/\/+|#+|\*|>)?[ \t]*/, "", line); line = rest " " line; rest = "" }
    while (match(line, /\[[A-Z][^][]*\]/)) {
      inside = substr(line, RSTART + 1, RLENGTH - 2)
      after = substr(line, RSTART + RLENGTH, 1)
      line = substr(line, RSTART + RLENGTH)
      if (after != "(") CheckKeys(inside)
    }
    if (match(line, /\[[A-Z][A-Za-z][^][]*$/)) rest = substr(line, RSTART)
  }
  END { exit bad > 0 }' <<<"$files" || exit 1
