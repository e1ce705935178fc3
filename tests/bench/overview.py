#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Draws the picture of the README from the quickstart's results.

usage: overview.py out/quickstart overview.png
"""
import json
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np


def read_obj(path):
    """Returns vertices [V, 3] in m and triangles [F, 3] of an OBJ file."""
    vertices, faces = [], []
    with open(path, encoding="utf-8") as lines:
        for line in lines:
            words = line.split()
            if words[:1] == ["v"]:
                vertices.append([float(w) for w in words[1:4]])
            elif words[:1] == ["f"]:
                faces.append([int(w.split("/")[0]) - 1 for w in words[1:4]])
    return np.array(vertices), np.array(faces)


def shade(vertices, faces, light):
    """Returns the brightness of each face, 0 to 1."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return 0.25 + 0.75 * np.abs(normals @ (np.array(light) / np.linalg.norm(light)))


def draw_drape(axes, vertices, faces):
    """Draws the drape in perspective, shaded."""
    colours = plt.cm.Blues(0.25 + 0.6 * (1.0 - shade(vertices, faces, (0.3, -0.5, 0.8))))
    surface = axes.plot_trisurf(*vertices.T, triangles=faces, linewidth=0, antialiased=False)
    surface.set_facecolors(colours)
    axes.set_box_aspect(np.ptp(vertices, axis=0), zoom=1.5)
    axes.view_init(elev=28, azim=-60)
    axes.set_axis_off()


def draw_intervals(axes, summary):
    """Draws bending lengths with their 90 % intervals."""
    rows = [row for row in summary["laboratory"]["material"]["rows"]
            if row["key"].startswith("bending_length")]
    for place, row in enumerate(reversed(rows)):
        axes.plot([row["low"], row["high"]], [place, place], color="#0072b2", linewidth=3)
        axes.plot(row["value"], place, "o", color="#0072b2")
        axes.text(row["high"] * 1.04, place, f"{row['value']:.2f} {row['unit']}", va="center")
    axes.set_yticks(range(len(rows)), [row["key"].split("_")[2] for row in reversed(rows)])
    axes.set_xlim(0, 1.5 * max(row["high"] for row in rows))
    axes.set_ylim(-0.7, len(rows) - 0.3)
    axes.set_xlabel(f"bending length [{rows[0]['unit']}], 90 % interval")
    axes.spines[["top", "right"]].set_visible(False)


def main(folder, picture):
    with open(f"{folder}/fit/summary.json", encoding="utf-8") as file:
        summary = json.load(file)
    figure = plt.figure(figsize=(13, 3.0))
    titles = ["silhouette", "outline: image blue, fit red", "fitted drape", "stiffness"]
    images = [f"{folder}/reference/silhouette.png", f"{folder}/fit/fit_silhouette.png"]
    for place, (title, image) in enumerate(zip(titles, images)):
        axes = figure.add_subplot(1, 4, place + 1, title=title)
        pixels = plt.imread(image)
        rows, columns = np.nonzero(pixels.reshape(*pixels.shape[:2], -1).min(axis=2) < 0.7)
        axes.imshow(pixels, cmap="gray")
        axes.set_xlim(columns.min() - 10, columns.max() + 10)
        axes.set_ylim(rows.max() + 10, rows.min() - 10)
        axes.set_axis_off()
    axes = figure.add_subplot(1, 4, 3, projection="3d", title=titles[2])
    draw_drape(axes, *read_obj(f"{folder}/fit/drape_silhouette.obj"))
    draw_intervals(figure.add_subplot(1, 4, 4, title=titles[3]), summary)
    figure.tight_layout()
    figure.savefig(picture, dpi=100)


if __name__ == "__main__":
    main(*sys.argv[1:])
