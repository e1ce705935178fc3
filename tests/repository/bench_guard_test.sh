#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# tests/bench/bench_guard on a drape_bench that makes its seconds up: a row for each ratio, what became
# slower is marked, --store keeps the ratios, a bench that fails is an error.
# usage: bench_guard_test.sh <source folder>
set -eu
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$scratch/tests/bench" "$scratch/build/bin"
cp "$1/tests/bench/bench_guard" "$scratch/tests/bench/"
guard=$scratch/tests/bench/bench_guard bench=$scratch/build/bin/drape_bench

cat >"$bench" <<'END'
#!/bin/sh
for option; do
  case $option in --work=*) work=${option#*=} ;; --out=*) out=${option#*=} ;; esac
done
[ -z "${FAIL:-}" ] || { echo "no seed" >&2; exit 2; }
mkdir -p "$out"
{
  echo "# settings"
  echo "mesh,solve,mode,seconds,cpu_seconds"
  case $work in
    forward)
      echo "disc:300,dynamic,adjoint,9,1"
      echo "disc:1200,dynamic,adjoint,9,${SECONDS_1200:-7}"
      echo "disc:300,static,adjoint,9,2"
      echo "disc:1200,static,adjoint,9,21" ;;
    gradient) echo "disc:300,dynamic,adjoint,9,3" ;;
    jacobian)
      echo "disc:300,dynamic,adjoint,9,10"
      echo "disc:300,dynamic,tangent,9,4" ;;
  esac
} >"$out/runs.csv"
END
chmod +x "$bench"

# expect <text>: a line of the report.
expect() {
  grep -qxF "$1" "$scratch/report" || {
    echo "expected the line: $1"
    cat "$scratch/report"
    exit 1
  }
}

"$guard" --store "$scratch/build" >"$scratch/report"
expect "forward: 1200 / 300 vertices, dynamic           7.000        -"
expect "Jacobian: adjoints / tangents, dynamic          2.500        -"
"$guard" "$scratch/build" >"$scratch/report"
[ "$(wc -l <"$scratch/report")" -eq 7 ]
expect "ratio of processor times                          now   stored   now/stored"
expect "forward: 1200 / 300 vertices, dynamic           7.000    7.000         1.00"
expect "forward: 1200 / 300 vertices, static           10.500   10.500         1.00"
expect "forward, 1200 vertices: static / dynamic        3.000    3.000         1.00"
expect "gradient by adjoint / forward, dynamic          3.000    3.000         1.00"
expect "Jacobian by tangents / forward, dynamic         4.000    4.000         1.00"
SECONDS_1200=14 "$guard" "$scratch/build" >"$scratch/report"
expect "forward: 1200 / 300 vertices, dynamic          14.000    7.000         2.00  slower than stored"
expect "forward, 1200 vertices: static / dynamic        1.500    3.000         0.50"

status=0
FAIL=yes "$guard" "$scratch/build" >"$scratch/report" 2>&1 || status=$?
[ $status -eq 2 ]
expect "no seed"
# What the repository stores are the ratios that the tool prints.
"$guard" "$scratch/build" >"$scratch/report"
for stored in "$1/tests/bench/guard.json" "$scratch/tests/bench/guard.json"; do
  sed -nE 's/^ *"(.*)": .*/\1/p' "$stored"
done | sort | uniq -c | awk '$1 != 2 { print "only in one of the two:", $0; bad = 1 } END { exit bad }'
