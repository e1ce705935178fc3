#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The root of the repository shows these names and no others.
# usage: top_level_test.sh <source folder>
set -eu
cd "$1"
expected='CHANGELOG.md CITATION.cff CMakeLists.txt CMakePresets.json LICENSE README.md configs cuda losses physics solver tests tools'

if ! tracked=$(git ls-files 2>/dev/null) || [ -z "$tracked" ]; then
  printf "tests/repository/top_level_test.sh: Skipped\nno git checkout here: no list of tracked files\n"
  exit 77
fi
found=$(echo "$tracked" | cut -d/ -f1 | grep -v '^\.' | LC_ALL=C sort -u | tr '\n' ' ')
if [ "$found" != "$expected " ]; then
  echo "top level holds: $found"
  echo "expected:        $expected"
  exit 1
fi
