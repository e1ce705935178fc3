#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Materials of a table of bending measurements in the form of [Feng 2022], with given stretch.

usage: bending_table.py TABLE.csv STRETCH.json [ROW ...] > bank.json

bank.json holds a material for each row (default: all; the first below the column names is 1), with
the stretch of STRETCH.json, a material file in the mechanical convention. Programs take it by
--fabric=bank.json#row_12. MODEL.md (M9) has the formula.
"""
import csv
import json
import sys

DIRECTIONS = ("warp", "diag", "weft")  # an edge along the weft bends the warp: rows 0, 1, 2


def read_material(row, stretch, name):
    """The material of a row {column: text}: rigidities at curvatures of 0, 10, … 40 /m."""
    linear = [1e-9 * float(row[f"linear {d}[SI*1e9]"]) for d in DIRECTIONS]
    nonlinear = [1e-12 * float(row[f"nonlinear {d}[SI*1e12]"]) for d in DIRECTIONS]
    return {"format": "drapefit-material", "version": 1, "name": name, "units": "SI",
            "source": f"bending of {name}, stretch of {stretch['name']}",
            "convention": "mechanical", "density": float(row["density[kg.m-2]"]),
            "stretch": stretch["stretch"],
            "bend": [[b1 + 10 * k * b2 for k in range(5)] for b1, b2 in zip(linear, nonlinear)]}


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    with open(sys.argv[2], encoding="utf-8") as file:
        stretch = json.load(file)
    if stretch.get("convention") != "mechanical":
        sys.exit(f"{sys.argv[2]}: expected a material file in the mechanical convention")
    with open(sys.argv[1], encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file, skipinitialspace=True))
    numbers = [int(word) for word in sys.argv[3:]] or range(1, len(rows) + 1)
    print(json.dumps({f"row_{n}": read_material(rows[n - 1], stretch, f"row_{n}")
                      for n in numbers}, indent=1))


if __name__ == "__main__":
    main()
