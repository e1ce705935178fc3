#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs the package to a scratch prefix and moves it; there builds and runs the consumer.
# usage: install_and_run.sh <build folder> <consumer source> <cmake> <generator> <C++ compiler>
set -eu
build=$1 source=$2 cmake=$3 generator=$4 compiler=$5

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

for component in devel configs; do
  "$cmake" --install "$build" --component "$component" --prefix "$scratch/first" >"$scratch/log" ||
    { cat "$scratch/log"; exit 1; }
done
mv "$scratch/first" "$scratch/prefix"

# Outside of `internal` lie solver/drapefit.h and the five headers that it includes; inside, what
# these include, and nothing of studies, programs and the inside of a backend.
include=$scratch/prefix/include/drapefit
{ echo solver/drapefit.h; sed -nE 's/^#include "([^"]+)".*/\1/p' "$include/solver/drapefit.h"; } |
  sort >"$scratch/public"
(cd "$include" && find . -path ./internal -prune -o -name '*.h' -print | cut -c 3- | sort) |
  diff "$scratch/public" -
[ "$(wc -l <"$scratch/public")" -le 6 ] || { echo "more than five public headers"; exit 1; }
for path in tools solver/studies solver/job/fit_report.h cuda/engine; do
  if [ -e "$include/internal/$path" ]; then echo "installed, but not needed: $path"; exit 1; fi
done
count=$(find "$include/internal" -name '*.h' | wc -l)
[ "$count" -le 70 ] || { echo "$count internal headers are installed, expected 70 at most"; exit 1; }
if find "$scratch/prefix" -name 'libdrape_*' | grep -E 'tools|studies|validation|verbs'; then
  echo "installed, but internal libraries"
  exit 1
fi
missing=$(cd "$include" && grep -rhoE '^#include "[^"]+"' . | sort -u | cut -d'"' -f2 |
  while read -r header; do [ -e "$header" ] || [ -e "internal/$header" ] || echo "$header"; done)
if [ -n "$missing" ]; then
  echo "included by public headers, but not installed:"
  echo "$missing"
  exit 1
fi
"$cmake" -S "$source" -B "$scratch/build" -G "$generator" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_PREFIX_PATH="$scratch/prefix"
"$cmake" --build "$scratch/build"

configs=$(dirname "$(find "$scratch/prefix" -type d -name fabrics)")
"$build/bin/drape_simulate" --mesh=disc:400 --fabric="$configs/fabrics/synthetic_wool.json" \
  --start="$configs/starts/six_waves.json" --solve=hybrid --out="$scratch/drape" >/dev/null
"$scratch/build/consumer" "$scratch/drape/silhouette.png" "$configs/fabrics/synthetic_shirt.json" |
  tee "$scratch/out"
grep -Eq '^(good|usable): bending rigidity B, as it drapes [0-9.]+ µN·m \([0-9.]+ … [0-9.]+\), measured' "$scratch/out"
