# SPDX-License-Identifier: Apache-2.0
"""What all scripts of studies share: reading OUT/<study>.json, and writing tables and charts.

A script calls main(draw, "<study>"), where draw(study) gets a Study. Its files are written to the
folder of the study; what it prints is what the program says.
"""

import csv
import json
import math
import os
import pathlib
import signal
import sys
import tempfile

try:
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({
        "svg.hashsalt": "drapefit",  # the same file for the same numbers
        "svg.fonttype": "none", "font.size": 10, "figure.dpi": 100, "axes.grid": True,
        "axes.axisbelow": True, "grid.color": "#dddddd", "legend.frameon": False,
        "figure.constrained_layout.use": True})
    import matplotlib.pyplot as pyplot
    import matplotlib.ticker
except ImportError:
    pyplot = None

COLOURS = ["#1f77b4", "#d62728", "#2ca02c", "#9467bd", "#ff7f0e", "#8c564b", "#17becf", "#7f7f7f"]
MARKERS = ["o", "s", "^", "D", "v", "p", "P", "X"]


class Study:
    """A folder with <study>.json, whose members are the items of this object."""

    def __init__(self, folder, name):
        self.folder = pathlib.Path(folder)
        self.json = json.loads((self.folder / (name + ".json")).read_text(encoding="utf-8"))

    def __getitem__(self, key):
        return self.json[key]

    def results(self):
        """The results of the cells that have one, each with the cell's "name" and "input"."""
        return [{"name": cell["name"], "input": cell["input"], **cell["result"]}
                for cell in self.json["cells"] if cell["result"] is not None]

    def write(self, name, text):
        (self.folder / name).write_text(text, encoding="utf-8")

    def write_csv(self, name, header, rows):
        with open(self.folder / name, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(header)
            writer.writerows([["" if cell is None else cell for cell in row] for row in rows])

    def save(self, figure, name):
        """Writes NAME.svg and NAME.png, with the build that made the numbers in the corner."""
        build = self.json.get("provenance", {}).get("build", {})
        if build:
            stamp = f"drapefit {build['drapefit']}, commit {build.get('commit') or 'unknown'}"
            figure.text(0.998, 0.003, stamp, ha="right", va="bottom", fontsize=6)
        figure.savefig(self.folder / (name + ".svg"), metadata={"Date": None})
        figure.savefig(self.folder / (name + ".png"), metadata={"Software": None})
        pyplot.close(figure)


def scale(axis, values):
    """Makes an axis logarithmic with plain numbers where the values span a factor of three."""
    if max(values) < 3 * min(values):
        return
    axis.axes.set(**{axis.axis_name + "scale": "log"})
    axis.set_major_locator(matplotlib.ticker.LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(matplotlib.ticker.NullFormatter())


def name_points(axes, points, names):
    """Writes each name beside its point, where it covers no other name and no point if it can."""
    axes.figure.canvas.draw()
    renderer = axes.figure.canvas.get_renderer()
    pixels = [axes.transData.transform(point) for point in points]
    taken = [(x - 4, y - 4, x + 4, y + 4) for x, y in pixels]

    def place(name, point, offset):
        side = "left" if offset[0] > 0 else "right" if offset[0] < 0 else "center"
        return axes.annotate(name, point, offset, textcoords="offset points", ha=side, va="center",
                             fontsize=9, parse_math=False)

    def covered(box):
        return sum(max(0, min(box[2], other[2]) - max(box[0], other[0]))
                   * max(0, min(box[3], other[3]) - max(box[1], other[1])) for other in taken)

    offsets = [(x * i, y * i) for i in (1, 2, 3) for x, y in
               [(7, 7), (-7, 7), (7, -7), (-7, -7), (0, 12), (0, -12)]]
    for point, name in zip(points, names):
        tried = []
        for offset in offsets:
            text = place(name, point, offset)
            box = text.get_window_extent(renderer).extents
            text.remove()
            tried.append((covered(box), len(tried), offset, tuple(box)))
            if tried[-1][0] == 0:
                break
        _, _, offset, box = min(tried)
        place(name, point, offset)
        taken.append(box)


def number(value, digits=3):
    """A number with so many significant digits, or "-"."""
    if value is None or not math.isfinite(value):
        return "-"
    return f"{value:.{digits}g}"


def aligned(header, rows):
    """A table for a terminal: the first column to the left, the others to the right."""
    lines = [[str(cell) for cell in line] for line in [header, *rows]]
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]
    return "".join(
        "  ".join([line[0].ljust(widths[0]), *map(str.rjust, line[1:], widths[1:])]).rstrip() + "\n"
        for line in lines)


def markdown(header, rows):
    """A table of Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "".join("| " + " | ".join(str(cell) for cell in line) + " |\n" for line in lines)


def main(draw, name):
    """Calls draw(study) for the folder of the command line, where its files appear together."""
    if len(sys.argv) != 2:
        sys.exit(f"usage: {name}.py FOLDER, which has {name}.json")
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    study = Study(sys.argv[1], name)
    folder = study.folder
    try:
        with tempfile.TemporaryDirectory(prefix=".drapefit_", dir=folder) as staged:
            study.folder = pathlib.Path(staged)
            draw(study)
            for file in study.folder.iterdir():
                os.replace(file, folder / file.name)
    except KeyboardInterrupt:
        sys.exit(130)
    if pyplot is None:
        print("no pictures: python3-matplotlib is not installed")
