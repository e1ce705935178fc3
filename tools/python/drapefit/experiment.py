# SPDX-License-Identifier: Apache-2.0
"""Experiments and scenes with arrays in memory, as the files that the programs read."""

import json
import os
import pathlib
import re
import struct
import tempfile
import zlib

import numpy as np

from . import _core

_FOLDER = "drapefit_"
_SCENES = pathlib.Path(__file__).parent / "scenes"


def temporary_folder():
    return tempfile.TemporaryDirectory(prefix=_FOLDER)


def without_folder(text):
    """A text without the names of temporary folders."""
    return re.sub(re.escape(tempfile.gettempdir() + os.sep + _FOLDER) + f"[^{os.sep}]*{os.sep}", "",
                  str(text))


def _array(key, value, *shape):
    """value as an array of this shape, of which None is any length."""
    array = np.asarray(value, float)
    if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape)):
        expected = ", ".join("N" if n is None else str(n) for n in shape)
        raise ValueError(f"{key}: found an array of the shape {list(array.shape)}, "
                         f"expected [{expected}]")
    return array


def _table(header, array):
    lines = [",".join(header)] + [",".join(map(repr, row)) for row in array.tolist()]
    return ("\n".join(lines) + "\n").encode()


def _markers(value, _):
    place = "vertices" if "vertices" in value else "places"
    if set(value) != {place, "positions"}:
        raise ValueError(f"markers: found the keys {sorted(value)}, expected positions and one of "
                         "places and vertices")
    positions = _array("positions", value["positions"], None, 3)
    if place == "vertices":
        names, places = ["vertex"], _array(place, value[place], len(positions))[:, None]
    else:
        names, places = ["weft_m", "warp_m"], _array(place, value[place], len(positions), 2)
    return ".csv", _table([*names, "x_m", "y_m", "z_m"], np.hstack([places, positions]))


def _points(value, _):
    return ".csv", _table(["x", "y", "z"], _array("points", value, None, 3))


def _shape(value, _):
    rows = _array("shape", value, None, 3).tolist()
    return ".obj", "".join("v {!r} {!r} {!r}\n".format(*row) for row in rows).encode()


def _state(value, _):
    if not isinstance(value, dict):
        x = _array("start", value, None, 3)
        value = {"x": x, "v": 0 * x}
    return _json(value, None)


def _json(value, _):
    return ".json", json.dumps(value, default=_plain).encode()


def _plain(value):
    """A value of numpy, a path or a camera for json."""
    if isinstance(value, os.PathLike):
        return os.path.abspath(value)
    if isinstance(value, _core.Camera):
        return json.loads(_core.camera_json(value))
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    raise ValueError(f"experiment: found {value!r}, expected a number, a text, a list, a dictionary "
                     "or an array")


def _png(pixels):
    """A grey picture of 8 or 16 bits from an array [H, W]."""
    def chunk(kind, content):
        body = kind + content
        return struct.pack(">I", len(content)) + body + struct.pack(">I", zlib.crc32(body))

    bits = 8 * pixels.itemsize
    rows = pixels.astype(pixels.dtype.newbyteorder(">"))
    data = b"".join(b"\0" + row.tobytes() for row in rows)
    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], bits, 0, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(data))
            + chunk(b"IEND", b""))


def _depth(value, measurement):
    """Depths [m], NaN where nothing is measured, or whole numbers of metres_per_count."""
    depth = _array("depth", value, None, None)
    if not np.issubdtype(np.asarray(value).dtype, np.integer):
        largest = np.nanmax(depth, initial=0.0)
        unit = measurement.setdefault("metres_per_count", max(float(largest), 1e-3) / 65535)
        depth = np.round(depth / unit)
        if np.nanmin(depth, initial=1) < 1:  # a count of 0 is no data
            raise ValueError(f"depth: found {np.nanmin(value):g} m, expected more than 0, or NaN "
                             "where nothing is measured")
        depth = np.nan_to_num(depth)
    if not (depth.min(initial=0) >= 0 and depth.max(initial=0) <= 65535):
        raise ValueError(f"depth: found counts from {depth.min():g} to {depth.max():g}, "
                         "expected 0 to 65535")
    return ".png", _png(depth.astype(np.uint16))


def _silhouette(value, _):
    """Coverage by cloth, 0 to 1."""
    coverage = _array("silhouette", value, None, None)
    if not (coverage.min(initial=0) >= 0 and coverage.max(initial=0) <= 1):
        raise ValueError("silhouette: found a coverage outside 0 to 1")
    return ".png", _png(np.round(255 * (1 - coverage)).astype(np.uint8))


# The files of what may be in memory, by key.
_WRITERS = {"markers": _markers, "points": _points, "shape": _shape, "depth": _depth,
            "silhouette": _silhouette, "start": _state}
# Keys of which a text is the path of a file.
_PATHS = {*_WRITERS, "material", "mesh", "scene", "view", "camera", "file"}


def scene_path(name):
    """The path of a scene: a file, or one of those in the package by its name."""
    own = _SCENES / f"{name}.json"
    return str(own) if not os.path.exists(name) and own.exists() else os.path.abspath(name)


def _name_file(key, value):
    if key == "scene":
        return scene_path(value)
    return value if key == "mesh" and ":" in str(value) else os.path.abspath(value)


def _prepare(tree, folder):
    """The tree with paths in place of what the programs read from files."""
    def new(key, ending):
        return folder / f"{key}_{len(os.listdir(folder)) + 1}{ending}"

    def store(key, ending, data):
        path = new(key, ending)
        path.write_bytes(data)
        return str(path)

    if isinstance(tree, (list, tuple)):
        return [_prepare(each, folder) for each in tree]
    if not isinstance(tree, dict):
        return tree
    found = dict(tree)
    for key, value in tree.items():
        is_text = isinstance(value, (str, os.PathLike))
        if is_text and key in _PATHS:
            found[key] = _name_file(key, value)
        elif key == "lab_tests":
            found[key] = [store(key, *_json(each, found)) if isinstance(each, dict) else
                          os.path.abspath(each) for each in value]
        elif not is_text and key in _WRITERS:
            found[key] = store(key, *_WRITERS[key](value, found))
        elif isinstance(value, (_core.Mesh, _core.Material)):
            path = new(key, ".obj" if isinstance(value, _core.Mesh) else ".json")
            value.write(str(path))
            found[key] = str(path)
        else:
            found[key] = _prepare(value, folder)
    return found


def write(tree, folder, name):
    """The path of a JSON file of this experiment or scene, with what it needs beside it."""
    path = pathlib.Path(folder) / name
    path.write_text(json.dumps(_prepare(tree, path.parent), default=_plain), encoding="utf-8")
    return str(path)
