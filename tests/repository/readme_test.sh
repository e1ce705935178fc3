#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# README.md agrees with the repository: its C++ example is the consumer, its paths exist.
# CITATION.cff names the version of the build.
# usage: readme_test.sh <source folder>
set -eu
cd "$1"
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

sed -n '/^```cpp$/,/^```$/p' README.md | grep -v '^```' >"$scratch/readme.cc"
tail -n +3 tests/repository/consumer/consumer.cc >"$scratch/consumer.cc"
diff "$scratch/readme.cc" "$scratch/consumer.cc"

status=0
for path in $(grep -oE '(configs|tests|tools)/[A-Za-z0-9_./]+|\]\([A-Za-z]+\.md\)' README.md |
              sed -E 's/^\]\(|\)$//g; s/\.$//' | sort -u); do
  [ -e "$path" ] || { echo "README.md names $path, which does not exist"; status=1; }
done
version=$(sed -nE 's/^project\(drapefit VERSION ([0-9.]+).*/\1/p' CMakeLists.txt)
grep -qx "version: $version" CITATION.cff ||
  { echo "CITATION.cff names another version than CMakeLists.txt: $version"; status=1; }
exit $status
