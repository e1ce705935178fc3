#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Words of words.txt do not come back into Markdown, configs, comments, messages and names.
# usage: words.sh <source folder> [<list of words> [<list of justified uses>]]
set -euo pipefail
export LC_ALL=C
list=$(realpath "${2:-$(dirname "$0")/words.txt}")
allowed=$(realpath "${3:-$(dirname "$0")/words_allowed.txt}")
cd "$1"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

if ! git ls-files -co --exclude-standard >"$scratch/listed" 2>/dev/null || [ ! -s "$scratch/listed" ]; then
  printf 'tests/repository/rules/words.sh: Skipped\nno git checkout here: no list of files\n'
  exit 77
fi
# The checks name the words that they look for.
grep -vE '^(LICENSE|tests/repository/.*)$' "$scratch/listed" |
  while IFS= read -r f; do [ ! -f "$f" ] || printf '%s\n' "$f"; done |
  xargs -d '\n' grep -lI '' >"$scratch/files"

# Three files with a line for each line of the sources: its place, its prose and its code.
xargs -d '\n' awk -v scratch="$scratch" '
  # Splits a line of C++ into `prose` (comments and the content of strings) and `code`.
  function Split(line,   close_at) {
    prose = code = ""
    while (line != "") {
      if (end != "") {  # in a comment or raw string that began on an earlier line
        close_at = index(line, end)
        prose = prose " " (close_at ? substr(line, 1, close_at - 1) : line)
        if (!close_at) return
        line = substr(line, close_at + length(end))
        end = ""
      } else if (!match(line, token)) {
        code = code line
        return
      } else {
        code = code substr(line, 1, RSTART - 1) " "
        found = substr(line, RSTART, RLENGTH)
        line = substr(line, RSTART + RLENGTH)
        if (found ~ /^\/\*/) end = "*/"
        else if (found ~ /^R"/) end = ")" substr(found, 3, length(found) - 3) "\""
        else prose = prose " " found
      }
    }
  }
  BEGIN { token = "R\"[A-Za-z]*\\(|\"([^\"\\\\]|\\\\.)*\"|\x27([^\x27\\\\]|\\\\.)[^\x27]*\x27|//.*|/\\*" }
  FNR == 1 { end = ""; cpp = FILENAME ~ /\.(h|cuh|cc|cu|in)$/ }
  {
    # A path in an #include is a name, which the file itself has to answer for.
    if ($0 ~ /^[ \t]*#[ \t]*include/) prose = code = ""
    else if (cpp) Split($0)
    else { prose = $0; code = "" }
    print FILENAME ":" FNR > (scratch "/where")
    print prose > (scratch "/prose")
    print code > (scratch "/code")
  }' <"$scratch/files"

while IFS= read -r rule; do
  scope=${rule%% *}
  regex=${rule#* }
  advice=${regex##* => }
  regex=${regex% => *}
  case $scope in
    prose) flags=-noiP ;;
    code) flags=-noP ;;
    *) echo "words.txt: $scope is no scope"; exit 1 ;;
  esac
  grep "$flags" -e "$regex" "$scratch/$scope" | sed "s~\$~\t$advice~" || [ $? -eq 1 ]
done < <(grep -vE '^(#|$)' "$list") >"$scratch/hits"

awk -F '\t' -v where="$scratch/where" -v prose="$scratch/prose" -v code="$scratch/code" -v allowed="$allowed" '
  BEGIN {
    while ((getline line < allowed) > 0) {
      if (line ~ /^#/ || !(at = index(line, ": "))) continue
      file_of[++uses] = substr(line, 1, at - 1)
      text_of[uses] = substr(line, at + 2)
    }
  }
  { at = index($1, ":"); n = substr($1, 1, at - 1) + 0; hits[n] = hits[n] "\n" substr($1, at + 1) "\t" $2 }
  END {
    for (n = 1; (getline place < where) > 0; ++n) {
      getline text < prose
      getline more < code
      if (!(n in hits)) continue
      file = place
      sub(/:[0-9]*$/, "", file)
      ok = 0
      for (i = 1; i <= uses; ++i)
        if (file == file_of[i] && index(text " " more, text_of[i])) { ok = 1; used[i] = 1 }
      if (ok) continue
      bad = 1
      count = split(substr(hits[n], 2), hit, "\n")
      for (i = 1; i <= count; ++i) {
        split(hit[i], part, "\t")
        print place ": \"" part[1] "\"; write: " part[2]
      }
    }
    for (i = 1; i <= uses; ++i)
      if (!(i in used)) { print "words_allowed.txt: " file_of[i] " no longer contains \"" text_of[i] "\""; bad = 1 }
    exit bad
  }' "$scratch/hits"
