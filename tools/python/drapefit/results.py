# SPDX-License-Identifier: Apache-2.0
"""What the programs of drapefit write."""

import json
import pathlib

import numpy as np

from . import _core


def read_folder(path):
    """What a program wrote: the content of each JSON file by its stem, such as summary; a table of
    a material is a Material, and outlines are radii in m, [N, K]."""
    results = {}
    for file in sorted(pathlib.Path(path).glob("*.json")):
        content = json.loads(file.read_text())
        kind = content.get("format") if isinstance(content, dict) else None
        if kind == "drapefit-material":
            content = _core.read_material(str(file))
        elif kind == "drapefit-outlines":
            content = np.array([drape["radius_m"] for drape in content["drapes"]])
        results[file.stem] = content
    if not results:
        raise ValueError(f"{path}: found no JSON file, expected the results of a program")
    return results
