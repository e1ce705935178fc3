#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# A room includes only its own headers and those of rooms listed before it in layers.txt, and a folder
# shows at most nine things: sub-folders and units (a header with the sources of the same stem).
# usage: layers.sh <source folder> [<list of rooms>]
set -euo pipefail
export LC_ALL=C
list=$(realpath "${2:-$(dirname "$0")/layers.txt}")
cd "$1"
folders='physics cuda losses solver tools'

# shellcheck disable=SC2086
if ! files=$(git ls-files -co --exclude-standard -- $folders 2>/dev/null) || [ -z "$files" ]; then
  printf 'tests/repository/rules/layers.sh: Skipped\nno git checkout here: no list of files\n'
  exit 77
fi
files=$(while IFS= read -r f; do [ ! -e "$f" ] || printf '%s\n' "$f"; done <<<"$files")

{
  sed -E 's/#.*//; s/[[:space:]]+$//; /^$/d; s/^/R /' "$list"
  sed 's/^/F /' <<<"$files"
  grep -E '\.(h|cuh|cc|cu|in)$' <<<"$files" |
    xargs -d '\n' grep -nE '^[[:space:]]*#[[:space:]]*include[[:space:]]*["<]' /dev/null |
    sed -E 's/^([^:]*):([0-9]+):[^"<]*(["<])([^">]*).*/I \1 \2 \3 \4/' || true
} | awk -v folders="$folders" '
  function RoomOf(path) {
    while (sub(/\/[^\/]*$/, "", path)) if (path in rank) return path
    return ""
  }
  function Inside(path, folder) { return path == folder || index(path, folder "/") == 1 }
  # The folder of a room at the level below physics, solver and so on.
  function Floor(room,   part) { return split(room, part, "/") > 1 ? part[1] "/" part[2] : room }
  function Report(where, what) { print where ": " what; bad = 1 }
  BEGIN { n = split(folders, own, " "); for (i = 1; i <= n; ++i) top[own[i]] = 1 }

  $1 == "R" && $2 == "@things" { most_things[$3] = $4; next }
  $1 == "R" && $2 == "@names" { most_names[$3] = $4; next }
  $1 == "R" && $2 == "@folder" { folder_rules[$3] = $0; next }
  $1 == "R" && $2 == "@apart" {
    ++groups
    for (i = 3; i <= NF; ++i) apart[$i] = groups
    next
  }
  $1 == "R" {
    if ($2 in rank) Report("layers.txt", "lists " $2 " twice")
    rank[$2] = ++rooms
    for (f in folder_rules) if (Inside($2, f)) {
      n = split(folder_rules[f], rule, " ")
      for (i = 4; i <= n; ++i) rules[$2] = rules[$2] " " rule[i]
    }
    for (i = 3; i <= NF; ++i) rules[$2] = rules[$2] " " $i
    next
  }

  $1 == "F" {
    exists[$2] = 1
    if ($2 ~ /\.(h|cuh|cc|cu|in)$/ && !(room[$2] = RoomOf($2)) && $2 !~ /\/cmake\//)
      Report($2, "in no room of layers.txt")
    if (room[$2]) used[room[$2]] = 1
    # Every folder above the file shows the next name on the way to it.
    depth = split($2, part, "/")
    folder = part[1]
    for (i = 2; i <= depth; ++i) {
      name = part[i]
      if (!((folder, name) in seen)) {
        seen[folder, name] = 1
        ++names[folder]
        thing = name
        if (i == depth && name ~ /\.(h|cuh|cc|cu|in)$/) sub(/\..*/, "", thing)
        if (name != "CMakeLists.txt" && name !~ /\.md$/ && !((folder, thing) in counted)) {
          counted[folder, thing] = 1
          ++things[folder]
          shown[folder] = shown[folder] " " thing
        }
      }
      folder = folder "/" name
    }
    next
  }

  $1 == "I" {
    from = room[$2]; where = $2 ":" $3; header = $5
    split(header, part, "/")
    if (!(part[1] in top) || index(header, "/") == 0) {
      if ($4 == "\"") Report(where, "includes \"" header "\": headers are named by their path from the root, and only those of " folders)
      next
    }
    if (!(header in exists)) { Report(where, "includes " header ", which does not exist"); next }
    to = room[header]
    if (from == "" || to == "" || from == to) next
    arrow[Floor(from), Floor(to)] = where
    if (rank[to] > rank[from]) Report(where, "includes " header ", but " to " is above " from)
    n = split(rules[from], rule, " ")
    forbidden = from in apart && to in apart && apart[from] == apart[to] ? to : ""
    for (i = 1; i <= n; ++i) {
      if (rule[i] == "+" header) { forbidden = ""; break }
      if (substr(rule[i], 1, 1) == "!" && Inside(to, substr(rule[i], 2))) forbidden = substr(rule[i], 2)
    }
    if (forbidden) Report(where, "includes " header ", but " from " may not include " forbidden)
  }

  END {
    for (pair in arrow) {
      split(pair, end, SUBSEP)
      if (end[1] < end[2] && (end[2], end[1]) in arrow)
        Report(arrow[pair], end[1] " includes " end[2] ", which includes it at " arrow[end[2], end[1]])
    }
    for (r in apart) if (!(r in rank)) Report("layers.txt", "@apart names " r ", which it does not list")
    for (r in rank) if (!(r in used)) Report("layers.txt", "lists " r ", which holds no source")
    for (f in things) {
      most = f in most_things ? most_things[f] : 9
      if (things[f] > most) Report(f, "shows " things[f] " things, at most " most ":" shown[f])
    }
    for (f in top) {
      most = f in most_names ? most_names[f] : 9
      if (names[f] > most) Report(f, "shows " names[f] " names, at most " most)
    }
    exit bad
  }' | sort
