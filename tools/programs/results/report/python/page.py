# SPDX-License-Identifier: Apache-2.0
"""The markup of a page within its size. All texts are escaped by the templates."""

import base64
import csv
import io
import json
import os
import re
import unicodedata

import jinja2
import markupsafe

import results

MOST_ROWS = 200  # of a table
LONGEST_TEXT = 20000  # characters


def printable(value):
    """Replaces control characters and halves of characters, and shortens endless texts."""
    if isinstance(value, markupsafe.Markup) or not isinstance(value, str):
        return value
    value = value if len(value) <= LONGEST_TEXT else value[:LONGEST_TEXT] + " …"
    return "".join("\ufffd" if unicodedata.category(c) in ("Cc", "Cs", "Cf") and c not in "\n\t" else c
                   for c in value)


def bold(value):
    return markupsafe.Markup(re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>",
                                    str(markupsafe.escape(printable(value)))))


ENVIRONMENT = jinja2.Environment(
    loader=jinja2.FileSystemLoader(os.path.join(os.path.dirname(__file__), "..", "templates")),
    autoescape=True, finalize=printable, trim_blocks=True, lstrip_blocks=True,
    undefined=jinja2.StrictUndefined)
ENVIRONMENT.filters["bold"] = bold
BLOCKS = ENVIRONMENT.get_template("blocks.html").module
details, paragraph, join = BLOCKS.details, BLOCKS.paragraph, markupsafe.Markup().join


# A cell of a table is its text and its kind: "", number, header, measured, prior.
def header(value):
    return value, "header"


def numeric(value):
    return value, "number"


def guess(value):
    """A number, an interval or a ratio is read from below and set to the right."""
    plain = re.sub("[…±–×]", "/", value)
    is_number = value == "none" or (re.search(r"[0-9/]", plain)
                                    and not re.search(r"[^0-9+\-.eE/%\[\], ]", plain))
    return value, "number" if is_number else ""


def origin(value):
    """The cell that says where a value is from, in the words of the fit."""
    return value, "prior" if value == "from the prior" else "measured" if value == "measured" else ""


def table(rows, head=(), caption=""):
    return BLOCKS.table(list(rows), list(head), caption)


def number_cell(value, pointer, factor=1, form="%.4g"):
    return numeric(results.number_text(value, pointer, factor, form) if pointer else "")


def number_rows(value, rows):
    """Rows of a name and the numbers at pointers, of which None leaves a cell empty."""
    return [(header(name), *(number_cell(value, pointer, factor, form)
                             for pointer in ((pointers,) if isinstance(pointers, str) else pointers)))
            for name, pointers, factor, form in rows]


def more_rows(rows, what="rows in the file", most=MOST_ROWS):
    left = len(rows) - most
    return paragraph(f"and {left} more {what}", "missing") if left > 0 else markupsafe.Markup()


def flat_rows(value, path=""):
    """Names and values of an object and of the objects in it."""
    if isinstance(value, dict):
        return [row for key in sorted(value)
                for row in flat_rows(value[key], f"{path} · {key}" if path else key)]
    if isinstance(value, list) and len(value) > 12:
        return [(header(path), (f"{len(value)} values", ""))]
    if isinstance(value, list) and any(isinstance(item, (dict, list)) for item in value):
        return [row for i, item in enumerate(value) for row in flat_rows(item, f"{path} · {i + 1}")]
    return [(header(path), (results.value_text(value), ""))]


def flat_table(value):
    rows = flat_rows(value)
    return table(rows[:MOST_ROWS]) + more_rows(rows)


def objects_table(objects, caption=""):
    """A table of objects of the same keys, without the objects in them."""
    keys = []
    for each in objects:
        keys += [key for key in sorted(each) if key not in keys and not isinstance(each[key], dict)]
    rows = [[guess(results.value_text(each[key])) if key in each else ("", "") for key in keys]
            for each in objects[:MOST_ROWS]]
    return table(rows, [key.replace("_", " ") for key in keys], caption) + more_rows(objects)


def csv_table(content):
    lines = [line for line in content.splitlines() if line.strip() and not line.startswith("#")]
    rows = [[field.strip() for field in row] for row in csv.reader(io.StringIO("\n".join(lines)))]
    shown = [[guess(field) for field in row] for row in rows[1:MOST_ROWS + 1]]
    return table(shown, rows[0] if rows else ()) + more_rows(rows[1:])


def markdown(content):
    """The tables, headings and paragraphs of a report, with "**" as strong."""
    html = []
    pieces = re.findall(r"(?:^\|.*\n?)+|^#+.*|(?:^[^|#\s].*\n?)+", content, re.MULTILINE)
    for piece in pieces:
        lines = [line.strip() for line in piece.strip().splitlines()]
        if piece.startswith("#"):
            html.append(BLOCKS.heading(piece.lstrip("#").strip()))
        elif piece.startswith("|"):
            rows = [[cell.strip() for cell in line.strip("|").split("|")]
                    for line in lines if line.strip("|-: ")]
            marked = [[(bold(cell), guess(cell)[1]) for cell in row] for row in rows[1:]]
            html.append(table(marked, rows[0] if rows else ()))
        else:
            html.append(paragraph(bold(" ".join(lines))))
    return join(html)


class Page:
    """A page while its parts are written."""

    def __init__(self, folders, room):
        self.folders = folders
        self.room = room  # bytes that are left
        self.taken = 0  # of the part that is being written
        self.sections = []  # id, heading, markup, whether it is folded
        self.folds = False  # what comes next: it is behind a first page
        self.drapes = []  # a list for each viewer
        self.bodies = []  # bodies that wear the drapes
        self.motion_share = None  # share of all frames that has room, found by drapes.py
        self.left_out = []

    def take(self, size, what):
        """Whether so many bytes find room, which they take; `what` is left out otherwise."""
        fits = size <= self.room
        if fits:
            self.room -= size
        else:
            self.left_out.append(what)
        return fits

    def fit(self, what, markup):
        """The markup, or a line that says that it found no room."""
        size = len(markup.encode())
        if not self.take(size, what):
            return paragraph(f"{what} has no room on this page", "missing")
        self.taken += size
        return markup

    def add(self, part, heading, markup):
        """A section of the page; one without content is left out."""
        if markup.strip():
            rest = len(markup.encode()) - self.taken
            if not self.take(rest, heading):
                self.room += self.taken
                markup = paragraph(f"{heading} has no room on this page", "missing")
            self.sections.append((part, heading, markup, self.folds))
        self.taken = 0

    def picture(self, path, alt, caption):
        """A PNG, JPEG or SVG file with its caption; a line for what is none of them."""
        try:
            kind, data = results.picture_for_page(path)
        except results.InputError as error:
            return paragraph(str(error), "missing")
        return self.data_picture(kind, data, alt, caption, path)

    def data_picture(self, kind, data, alt, caption, what):
        return self.fit(what, BLOCKS.picture(uri(kind, data), alt, caption,
                                             "chart" if kind == "svg+xml" else "picture"))

    def side_by_side(self, part):
        """Puts the markup of `part` for each folder side by side. Several folders have headings."""
        contents = [(folder.name if len(self.folders) > 1 else "", part(folder, self))
                    for folder in self.folders]
        contents = [each for each in contents if each[1].strip()]
        return BLOCKS.side_by_side(contents) if contents else markupsafe.Markup()


def uri(kind, data):
    return f"data:image/{kind};base64," + base64.b64encode(data).decode()


def script_json(value):
    """JSON that may stand inside <script>."""
    return json.dumps(value, separators=(",", ":")).replace("<", "\\u003c")
