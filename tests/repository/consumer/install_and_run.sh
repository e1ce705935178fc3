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

# Public headers only, each with all headers that it includes; no studies and no programs.
include=$scratch/prefix/include/drapefit
for path in tools solver/studies solver/job/plot cuda/engine cuda/kernels losses/metrics/hausdorff.h; do
  if [ -e "$include/$path" ]; then echo "installed, but no public header: $path"; exit 1; fi
done
if find "$scratch/prefix" -name 'libdrape_*' | grep -E 'tools|studies|validation|program'; then
  echo "installed, but internal libraries"
  exit 1
fi
missing=$(cd "$include" && grep -rhoE '^#include "[^"]+"' . | sort -u | cut -d'"' -f2 |
  while read -r header; do [ -e "$header" ] || echo "$header"; done)
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
grep -Eq '^(good|usable): bending rigidity [0-9.]+ uN m, 90 % interval [0-9.]+ to [0-9.]+$' "$scratch/out"
