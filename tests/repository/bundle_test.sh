#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# A bundle that was moved drapes a fabric in an empty environment, with the libraries that it brought.
# usage: bundle_test.sh <source folder> <build folder>
set -eu
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() { echo "$*"; exit 1; }

"$1/tools/bundle" "$2" "$scratch/first"
mv "$scratch/first" "$scratch/moved place"
cd "$scratch/moved place"

for program in bin/*; do
  [ -h "$program" ] && continue
  loaded=$(env -i /usr/bin/ldd "$program" 2>&1) || true
  for library in lib/*; do
    name=${library#lib/}
    case $loaded in
      *"$name => $PWD/bin/../lib/$name "*) ;;
      *"$name => "*) fail "$program does not take $name from the bundle" ;;
    esac
  done
done

cd /
env -i "$scratch/moved place/bin/drape_simulate" --mesh=disc:100 --steps=2 \
  --fabric="$scratch/moved place/configs/fabrics/synthetic_wool.json" --out="$scratch/out"
[ -s "$scratch/out/summary.json" ] || fail "no summary.json"
env -i "$scratch/moved place/bin/drape_report" "$scratch/out" --out="$scratch/report.html"
[ -s "$scratch/report.html" ] || fail "no report"
(cd "$1/configs" && find . -type f) | while read -r file; do
  cmp -s "$1/configs/$file" "$scratch/moved place/configs/$file" || fail "lacks configs/$file"
done

if "$1/tools/bundle" --test "$2" "$scratch/none" 2>"$scratch/log"; then fail "took --test"; fi
grep -q 'expected --all or --tests' "$scratch/log"
if [ -x "$2/bin/cuda_test" ] && [ -x "$2/bin/bench_cuda" ]; then
  "$1/tools/bundle" --tests "$2" "$scratch/tests"
  mv "$scratch/tests" "$scratch/moved tests"
  cd "$scratch/moved tests"
  grep -q 'bin/bench_cuda' BUNDLE.txt
  # By a sanitizer that only tells how it was called.
  mkdir "$scratch/tool"
  printf '#!/bin/sh\necho "GPU 0"\n' >"$scratch/tool/nvidia-smi"
  printf '#!/bin/sh\necho "called $*"\n[ "$1" = --tool=memcheck ]\n' >"$scratch/tool/compute-sanitizer"
  chmod +x "$scratch"/tool/*
  if PATH=$scratch/tool:$PATH bin/compute_sanitizer --gtest_filter=None >"$scratch/log"; then
    fail "compute_sanitizer says nothing of reports"
  fi
  grep -q "called --tool=initcheck .*/moved tests/bin/cuda_test --gtest_filter=None" "$scratch/log"
  grep -q '^compute-sanitizer memcheck: clean' "$scratch/log"
  grep -q '^compute-sanitizer racecheck: exit code 1' "$scratch/log"
  env -i bin/cuda_test --gtest_list_tests | grep -q Cuda || fail "no test of CUDA"
  env -i DRAPE_SHARED=/elsewhere bin/cuda_test --gtest_filter='CudaGolden*' |
    grep -q 'found no /elsewhere/golden/materials.json: set DRAPE_SHARED' ||
    fail "cuda_test does not say why it skips the tests of golden files"
  # Without a device it ends after these lines.
  (env -i bin/bench_cuda --meshes= || true) | grep -qF "fabrics: $PWD/configs/fabrics" ||
    fail "bench_cuda does not look for the fabrics of the bundle"
  DRAPE_CONFIGS=/elsewhere bin/bench_cuda --meshes= | grep -qxF "fabrics: /elsewhere/fabrics" ||
    fail "bench_cuda ignores DRAPE_CONFIGS"
  cd /
else
  if "$1/tools/bundle" --tests "$2" "$scratch/none" 2>"$scratch/log"; then fail "packed no test"; fi
  grep -q 'needs a CUDA build' "$scratch/log"
  [ ! -e "$scratch/none" ] || fail "left a bundle without the tests"
fi

mkdir "$scratch/occupied"
echo precious >"$scratch/occupied/file"
if "$1/tools/bundle" "$2" "$scratch/occupied" 2>"$scratch/log"; then fail "overwrote a folder"; fi
grep -q 'no earlier bundle' "$scratch/log"
[ -s "$scratch/occupied/file" ] || fail "emptied a folder"
