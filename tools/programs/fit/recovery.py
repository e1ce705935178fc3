#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Which numbers of a fit can be trusted: fitted over known stiffness of fits with --ground_truth.

usage: recovery.py [--out=CHART.png] FOLDER_OF_DRAPE_FIT...
"""
import json
import pathlib
import sys

import numpy

# Rows of the laboratory's sheet with an interval, then means of tables, the best visible first.
ROWS = {
    "bending_in_drape_un_m": "B, as it drapes", "bending_overall_un_m": "B, overall",
    "bending_warp_un_m": "B, warp", "bending_weft_un_m": "B, weft",
    "bend_at_45_deg_n_m": "bend, 45 deg edges", "c33_n_per_m": "shear c33",
    "c11_n_per_m": "stretch c11", "c22_n_per_m": "stretch c22"}
SHEET = [key for key in ROWS if key.endswith("_un_m")]


def fail(message):
    print("recovery.py: " + message, file=sys.stderr)
    sys.exit(2)


def rows_of(summary, sheet):
    return {row["key"]: row for row in summary["laboratory"][sheet]["rows"]}


def read(folders):
    """Ratios fitted/reference, then factors of 90 % intervals and whether these hold, by key; then
    the fits left out."""
    ratios = {key: [] for key in ROWS}
    claims = {key: [] for key in SHEET}
    left_out = 0
    for folder in folders:
        path = pathlib.Path(folder, "summary.json")
        try:
            summary = json.loads(path.read_text())
            if summary["verdict"]["grade"] == "do not use":
                left_out += 1
                continue
            for key in ROWS:
                if key not in SHEET:
                    quantity = summary["stiffness"][key]
                    ratios[key].append(quantity["fitted"] / quantity["reference"])
            fitted, reference = rows_of(summary, "material"), rows_of(summary, "reference")
            for key in SHEET:
                row, known = fitted[key], reference[key]["value"]
                if row["low"] is None or row["high"] is None:  # not measured, or a bound
                    continue
                ratios[key].append(row["value"] / known)
                claims[key].append(((row["high"] / row["low"]) ** 0.5,
                                    row["low"] <= known <= row["high"]))
        except (OSError, ValueError) as error:
            fail(f"{path}: {error}")
        except (KeyError, TypeError) as error:
            fail(f"{path}: found no {error}, expected a fit with --ground_truth")
    if left_out == len(folders):
        fail(f"{folders[0]}: none of {left_out} fits is usable, expected one at least")
    return ratios, {key: numpy.array(of_key) for key, of_key in claims.items() if of_key}, left_out


def table(ratios, claims, left_out):
    fits = len(ratios["c33_n_per_m"])
    print(f"{fits} fits of known fabrics, {left_out} more left out as not to be used")
    print(f"{'fitted/reference':24} {'5 %':>8} {'median':>8} {'95 %':>8} {'claimed':>10} {'inside':>8}")
    for key, label in ROWS.items():
        if not ratios[key]:
            continue
        low, middle, high = numpy.quantile(ratios[key], [0.05, 0.5, 0.95])
        line = f"{label:24} {low:8.2f} {middle:8.2f} {high:8.2f}"
        if key in claims:
            factor, inside = numpy.median(claims[key][:, 0]), claims[key][:, 1].mean()
            line += f"   to {factor:.2f} x {100 * inside:7.0f} %"
        print(line)


def draw(ratios, claims, path):
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(6.4, 4.4), layout="constrained")
    axes.axvline(1, color="#555555", linewidth=1)
    for row, key in enumerate(ROWS):
        if not ratios[key]:
            continue
        shown = numpy.clip(ratios[key], 0.1, 10)
        low, middle, high = numpy.quantile(shown, [0.05, 0.5, 0.95])
        axes.plot(shown, [row] * len(shown), "o", color="#aaaaaa", markersize=3)
        axes.plot([low, high], [row + 0.22] * 2, color="#21918c", linewidth=3)
        axes.plot(middle, row + 0.22, "o", color="#21918c", markersize=6)
        if key in claims:
            factor = numpy.median(claims[key][:, 0])
            axes.plot([1 / factor, factor], [row + 0.4] * 2, color="#d62728", linewidth=3)
    axes.set(xscale="log", xlim=(0.1, 10), ylim=(len(ROWS) - 0.3, -0.5), xlabel="fitted / reference")
    axes.set_title(f"dots: {len(ratios['c33_n_per_m'])} fits of drapes of known fabrics; green: median "
                   "and 90 % of them;\nred: the 90 % interval that fits state", fontsize=8)
    axes.set_xticks([0.1, 0.2, 0.5, 1, 2, 5, 10], ["0.1", "0.2", "0.5", "1", "2", "5", "10"])
    axes.set_yticks(range(len(ROWS)), ROWS.values())
    figure.suptitle("Which numbers of a fit can be trusted?")
    figure.savefig(path, dpi=100)


def main(arguments):
    folders = [word for word in arguments if not word.startswith("--out=")]
    charts = [word[len("--out="):] for word in arguments if word.startswith("--out=")]
    if not folders or folders[0].startswith("-"):
        fail("expected output folders of drape_fit with --ground_truth\n" + __doc__)
    found = read(folders)
    table(*found)
    for chart in charts:
        draw(*found[:2], chart)


if __name__ == "__main__":
    main(sys.argv[1:])
