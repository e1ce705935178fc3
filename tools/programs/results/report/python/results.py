# SPDX-License-Identifier: Apache-2.0
"""Reads the files of finished runs. No file is trusted: links, pipes and damaged files are refused."""

import dataclasses
import hashlib
import io
import json
import math
import os
import re
import stat
import warnings
import xml.etree.ElementTree

import PIL.Image

MOST_BYTES = 200_000_000  # of one file
LARGE_PICTURE = 200_000  # bytes, from which a picture is shown as a thumbnail
THUMBNAIL_SIDE = 1000  # px
MOST_LEVELS = 64  # of lists and objects
PIL.Image.MAX_IMAGE_PIXELS = 50_000_000

# A key of each kind of JSON file that drape_metrics writes.
METRICS_KEYS = ("shape", "drapes", "aligned", "outline_energy_score_m", "trivial_predictors")


class InputError(Exception):
    """A fault of a file, in one line."""


def open_file(path):
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError as error:
        reason = "is a symbolic link" if os.path.islink(path) else os.strerror(error.errno)
        raise InputError(f"{path}: {reason}, expected a file") from None
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        raise InputError(f"{path}: is no file, expected a file")
    return os.fdopen(handle, "rb")


def read_bytes(path):
    with open_file(path) as file:
        size = os.fstat(file.fileno()).st_size
        if size > MOST_BYTES:
            raise InputError(f"{path}: has {size} bytes, expected at most {MOST_BYTES}")
        return file.read()


def read_text(path):
    return read_bytes(path).decode("utf-8", "replace")


def finite(text):
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"found {text}, expected a number within the range of double")
    return value


def unique(pairs):
    members = dict(pairs)
    if len(members) < len(pairs):
        raise ValueError("has a key twice")
    return members


def read_json(path):
    try:
        document = json.loads(read_bytes(path), parse_float=finite, parse_constant=finite,
                              object_pairs_hook=unique)
        level = [document]
        for _ in range(MOST_LEVELS):  # some work on values is recursive
            level = [value for each in level if isinstance(each, (dict, list))
                     for value in (each.values() if isinstance(each, dict) else each)]
        if any(isinstance(each, (dict, list)) for each in level):
            raise ValueError(f"has values nested deeper than {MOST_LEVELS}")
        return document
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: is no JSON file: {error}") from None


def decode_picture(path, data):
    """The picture of a PNG or JPEG file, decoded to its last pixel."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            picture = PIL.Image.open(io.BytesIO(data), formats=("PNG", "JPEG"))
            picture.load()
            return picture
    except Exception as error:  # of Pillow's many readers
        raise InputError(f"{path}: is no picture: {error}") from None


def picture_for_page(path):
    """The type and the bytes of a picture; a large one, such as a photograph, as a thumbnail."""
    data = read_bytes(path)
    if path.endswith(".svg"):
        try:
            if b"<!ENTITY" in data or not xml.etree.ElementTree.fromstring(data).tag.endswith("svg"):
                raise ValueError("found another document")
        except (ValueError, xml.etree.ElementTree.ParseError) as error:
            raise InputError(f"{path}: is no SVG: {error}") from None
        return "svg+xml", data
    picture = decode_picture(path, data)
    if len(data) < LARGE_PICTURE:
        return picture.format.lower(), data
    picture = picture.convert("RGB")
    picture.thumbnail((THUMBNAIL_SIDE, THUMBNAIL_SIDE), PIL.Image.Resampling.BOX)
    small = io.BytesIO()
    picture.save(small, "JPEG", quality=85)
    return "jpeg", small.getvalue()


def find(value, pointer):
    """The member "/verdict/grade"; None where there is none."""
    for part in pointer.split("/")[1:]:
        if isinstance(value, dict):
            value = value.get(part)
        elif isinstance(value, list) and part.isdigit() and int(part) < len(value):
            value = value[int(part)]
        else:
            return None
    return value


def number(value, pointer):
    found = find(value, pointer)
    return None if isinstance(found, bool) or not isinstance(found, (int, float)) else float(found)


def text(value, pointer):
    found = find(value, pointer)
    return found if isinstance(found, str) else ""


def items(value, pointer, kind=dict):
    """The items of a list that are of this kind."""
    found = find(value, pointer)
    return [item for item in found if isinstance(item, kind)] if isinstance(found, list) else []


def texts(value, pointer):
    return items(value, pointer, str)


def directions(value):
    """What the directions of warp and weft are called: otherwise where it is not known which is which."""
    names = texts(value, "/directions")
    return names if len(names) == 2 else ["warp", "weft"]


def number_text(value, pointer, factor=1, form="%.4g"):
    found = number(value, pointer)
    return "none" if found is None else form % (factor * found)


def value_text(value):
    """One line of a value, as a person reads it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return "%.4g" % value
    if isinstance(value, list):
        return ", ".join(value_text(item) for item in value) or "none"
    if value is None:
        return "none"
    return value if isinstance(value, str) else json.dumps(value, sort_keys=True)


def coefficient_text(photograph):
    """The drape coefficient of a photograph and its standard deviation [%]: "27.3 ± 0.3"."""
    found = number_text(photograph, "/dc", 100, "%.1f")
    if number(photograph, "/dc_sd") is None:
        return found
    return found + number_text(photograph, "/dc_sd", 100, " ± %.1f")


def file_order(name):
    """draw_2 comes before draw_10."""
    return [(len(part), part) if part.isdigit() else (0, part) for part in re.split(r"(\d+)", name)]


@dataclasses.dataclass
class Folder:
    """The results of a program in a folder, or of drape_metrics in a file."""

    path: str
    name: str  # for headings
    program: str
    file: str  # of the summary, in the folder
    summary: dict

    @property
    def is_fit(self):
        return self.program == "drape_fit"

    def at(self, file):
        return os.path.join(self.path, file) if file else self.path

    def discs(self):
        """Diameters of specimen and support [m]; None for results without them."""
        sizes = [number(self.summary, f"/{disc}_diameter_m") for disc in ("specimen", "support")]
        return None if None in sizes else tuple(sizes)

    def files(self, *ends):
        if not os.path.isdir(self.path):
            return []
        names = [entry.name for entry in os.scandir(self.path)
                 if entry.name.endswith(ends) and not entry.name.startswith(".")
                 and not entry.is_dir(follow_symlinks=False)]
        return sorted(names, key=file_order)

    def changed(self, path):
        """Whether the run read another content of this file."""
        for file in items(self.summary, "/provenance/inputs"):
            if text(file, "/path") == path and text(file, "/sha256"):
                return hashlib.sha256(read_bytes(path)).hexdigest() != text(file, "/sha256")
        return False


def program_of(summary):
    if not isinstance(summary, dict):
        return ""
    return text(summary, "/tool") or text(summary, "/provenance/program")


def read_folder(path):
    if not os.path.lexists(path):
        raise InputError(f"{path}: no such folder")
    if not os.path.isdir(path):
        expected = "expected a folder of results or a JSON file of drape_metrics"
        if not path.endswith(".json"):
            raise InputError(f"{path}: is not a folder, {expected}")
        summary = read_json(path)
        if not isinstance(summary, dict) or not set(METRICS_KEYS) & set(summary):
            raise InputError(f"{path}: has no results of drape_metrics, {expected}")
        return Folder(path, os.path.basename(path), "drape_metrics", "", summary)
    folder = Folder(path, os.path.basename(os.path.realpath(path)), "", "", {})
    names = folder.files(".json")
    for name in sorted(names, key=lambda name: (name != "summary.json", names.index(name))):
        try:
            summary = read_json(folder.at(name))
        except InputError:
            if name == "summary.json":
                raise
            continue
        if program_of(summary):
            return dataclasses.replace(folder, program=program_of(summary), file=name, summary=summary)
    raise InputError(f"{path}: has no results, expected the output folder of a program of drapefit")


def find_photograph(image):
    """The folder of drape_photo that an image of a fit is from, while it is there."""
    folder, name = os.path.split(text(image, "/file"))
    try:
        found = read_folder(folder or ".") if name else None
    except (InputError, ValueError):
        return None
    known = found and found.program == "drape_photo" and name in (
        text(found.summary, "/silhouette"), text(found.summary, "/projected"))
    return found if known else None
