#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# README.md agrees with the repository: its C++ example is the consumer, its paths exist.
# usage: readme_test.sh <source folder>
set -eu
cd "$1"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

sed -n '/^```cpp$/,/^```$/p' README.md | grep -v '^```' >"$scratch/readme.cc"
tail -n +2 tests/repository/consumer/consumer.cc >"$scratch/consumer.cc"
diff "$scratch/readme.cc" "$scratch/consumer.cc"

status=0
for path in $(grep -oE '(configs|tests|tools)/[A-Za-z0-9_./]+|\]\([A-Za-z]+\.md\)' README.md |
              sed -E 's/^\]\(|\)$//g; s/\.$//' | sort -u); do
  [ -e "$path" ] || { echo "README.md names $path, which does not exist"; status=1; }
done
exit $status
