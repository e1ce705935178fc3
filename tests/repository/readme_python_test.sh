#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Runs the Python block of README.md as it is printed, where it finds what it reads.
# usage: readme_python_test.sh <source folder> <build folder> <python> <silhouette>
set -eu
source=$1 build=$2 python=$3 silhouette=$4
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

cd "$scratch"
mkdir -p out/quickstart/reference
cp "$silhouette" out/quickstart/reference/silhouette.png
ln -s "$source/configs" configs
sed -n '/^```python$/,/^```$/p' "$source/README.md" | grep -v '^```' >readme.py
[ -s readme.py ] || { echo "README.md has no block in Python"; exit 1; }
PYTHONPATH=$build/python "$python" -B readme.py | tee out/printed
grep -Eq '^(good|usable) [0-9.e+-]+ [0-9.e+-]+$' out/printed
