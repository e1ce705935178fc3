#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# An installed package has the programs, and what README.md and tools/README.md name in configs/: its
# commands run from there.
# usage: installed_test.sh <source folder> <build folder> <cmake>
set -eu
source=$1 build=$2 cmake=$3
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

for component in programs configs; do
  "$cmake" --install "$build" --component "$component" --prefix "$scratch/prefix" >"$scratch/log" ||
    { cat "$scratch/log"; exit 1; }
done
bin=$scratch/prefix/bin
cd "$scratch/prefix/share/drapefit"

status=0
for path in man/man1/drapefit.1 man/man1/drape_fit.1 bash-completion/completions/drape_fit; do
  [ -s "$scratch/prefix/share/$path" ] || { echo "not installed: share/$path"; status=1; }
done
for path in $(grep -ohE 'configs/[A-Za-z0-9_./]+' "$source/README.md" "$source/tools/README.md" |
              sed 's/\.$//' | sort -u); do
  [ -e "$path" ] || { echo "not installed: $path"; status=1; }
done
(cd "$source" && find configs -type f) | while read -r file; do
  [ -e "$file" ] || echo "not installed: $file"
done >"$scratch/missing"
if [ -s "$scratch/missing" ]; then cat "$scratch/missing"; status=1; fi

run() {
  echo "$*"
  "$@" >"$scratch/out" 2>&1 || { cat "$scratch/out"; status=1; }
}
# The Python package, where it is built: from its installed folder alone.
if [ -e "$build/python" ]; then
  run "$cmake" --install "$build" --component python --prefix "$scratch/prefix"
  python=$(sed -n 's/^Python_EXECUTABLE:[A-Z]*=//p' "$build/CMakeCache.txt")
  run env PYTHONPATH="$scratch/prefix/lib/python3/dist-packages" "$python" -c \
    'import drapefit; assert drapefit.Simulator(drapefit.disc(200)).camera.width == 256'
fi
run "$bin/drape_simulate" --mesh=disc:100 --fabric=configs/fabrics/synthetic_wool.json \
  --start=configs/starts/six_waves.json --steps=5 --time_step=0.1 --out="$scratch/drape"
run "$bin/drape_report" "$scratch/drape" --out="$scratch/report.html"
run "$bin/drape_simulate" --scene=configs/scenes/hanging_strip.json --mesh=strip:0.1x0.02x10 \
  --fabric=configs/fabrics/synthetic_wool.json --steps=2 --out="$scratch/strip"
run "$bin/drapefit" check --config=configs/programs/check.json --mesh=disc:100 --steps=5
run "$bin/drape_equilibria" --config=configs/programs/equilibria.json --mesh=disc:100 --samples=1 \
  --steps=5 --out="$scratch/equilibria"
exit $status
