# SPDX-License-Identifier: Apache-2.0
"""Images and drapes: outlines as layers over the image, drapes from above, drapes to turn."""

import base64
import os

import numpy as np

import page as html
from results import (InputError, coefficient_text, decode_picture, find, items, number, number_text,
                     open_file, read_bytes, read_json, read_text, text, texts)

MOST_DRAPES, MOST_TILES, MOST_BRANCHES, MOST_LARGE = 12, 96, 30, 2  # of one folder
LISTED_ANGLES = 120  # of outlines.json
COLOURS = 7  # of style.css
USUAL_DISCS, USUAL_SCALE = (0.30, 0.18), 719.5  # diameters [m], px/m


def svg_path(radius, cx, cy, digits=2):
    angles = 2 * np.pi * np.arange(len(radius)) / len(radius)
    form = f"%.{digits}f %.{digits}f"
    return "M" + "L".join(form % point for point in zip(cx + radius * np.cos(angles),
                                                        cy - radius * np.sin(angles))) + "Z"


# Images and outlines

def image_outlines(folder, image, page, shown=("image", "fitted")):
    """What is seen, size, data, outlines that the fit has stored, discs and 5 cm of an image of a fit
    [px]. The flat cloth may be larger than the image."""
    file = text(image, "/file")
    if folder.changed(file):
        raise InputError(f"{file}: is not the file that was fitted: it has changed since")
    sizes = [number(image, key) for key in ("/camera/width", "/camera/height", "/camera/cx",
                                            "/camera/cy", "/outlines/px_per_m")]
    radii = {name: np.array(items(image, f"/outlines/{name}_px", (int, float)), float)
             for name in ("image", "fit")}
    if None in sizes or not all(len(radius) for radius in radii.values()):
        raise InputError(f"{file}: has no outlines in the summary")
    width, height, (cx, cy, px_per_m) = int(sizes[0]), int(sizes[1]), sizes[2:]
    data = read_bytes(file)
    if decode_picture(file, data).size != (width, height):
        raise InputError(f"{file}: has another size than the fit's image")
    paths = [(layer, svg_path(radii[name], cx + 0.5, cy + 0.5))
             for layer, name in (("image", "image"), ("fitted", "fit")) if layer in shown]
    uri = html.uri("jpeg" if data.startswith(b"\xff\xd8") else "png", data)
    specimen, support = folder.discs() or USUAL_DISCS
    rings = [(cx + 0.5, cy + 0.5, size / 2 * px_per_m) for size in (support, specimen)]
    ends = [f(*sides) for f, *sides in ((min, 0, cx - rings[1][2]), (min, 0, cy - rings[1][2]),
                                        (max, width, cx + rings[1][2]), (max, height, cy + rings[1][2]))]
    view = (ends[0] - 2, ends[1] - 2, ends[2] - ends[0] + 4, ends[3] - ends[1] + 4)
    return (view, (width, height), uri if page and page.take(len(uri), file) else "", paths, rings,
            0.05 * px_per_m)


def layers(folder, image, page):
    """The outlines over the image."""
    return html.BLOCKS.layers(f"Outline of {text(image, '/file')} and of the fitted drape",
                              *image_outlines(folder, image, page))


def stored_overlay(folder, name, reason, page):
    """The picture that the fit wrote, of an image that can no longer be read."""
    file = folder.at(f"fit_{name}.png")
    if not os.path.lexists(file):
        return html.paragraph(reason, "missing")
    return page.picture(file, "Outlines of the image, blue, and of the fit, red", reason)


def image_metrics(image):
    mm_per_px = 1e3 / (number(image, "/camera/px_per_m") or USUAL_SCALE)
    rows = html.number_rows(image, [
        ("drape coefficient [%]", ("/metrics/dc_image", "/metrics/dc_fit"), 100, "%.1f"),
        ("nodes", ("/metrics/folds_image", "/metrics/folds_fit"), 1, "%.0f"),
        ("outline error, rms [mm]", (None, "/metrics/profile_rms_px"), mm_per_px, "%.2f"),
        ("the same after settling [mm]", (None, "/settled/metrics/profile_rms_px"), mm_per_px, "%.2f"),
        ("overlap of the areas (IoU) [%]", (None, "/metrics/iou"), 100, "%.1f"),
        ("lowest vibration [Hz]", (None, "/stability/lowest_frequency_hz"), 1, "%.2f")])
    if find(image, "/photograph"):
        rows.insert(1, (html.header("the photograph's, ± standard deviation [%]"),
                        html.numeric(coefficient_text(image["photograph"])), html.numeric("")))
    return html.table(rows, ("", "image", "fit"))


def image_part(folder, image, page):
    name = text(image, "/name")
    try:
        picture = layers(folder, image, page)
    except InputError as error:
        picture = stored_overlay(folder, name, str(error), page)
    notes = html.join(html.paragraph(note, "quiet") for note in texts(image, "/quality/notes"))
    return html.BLOCKS.columns(html.paragraph(name, "quiet") + picture, image_metrics(image) + notes)


def small_image(folder, image):
    try:
        view, _, _, paths, rings, _ = image_outlines(folder, image, None)
    except InputError:  # the numbers are known
        view, paths, rings = (0, 0, 1, 1), [], []
    mm_per_px = 1e3 / (number(image, "/camera/px_per_m") or USUAL_SCALE)
    return (text(image, "/name"), view, paths, rings, "DC %s, fit %s %%, %s mm rms" % (
        number_text(image, "/metrics/dc_image", 100, "%.1f"),
        number_text(image, "/metrics/dc_fit", 100, "%.1f"),
        number_text(image, "/metrics/profile_rms_px", mm_per_px, "%.1f")))


def images(folder, page):
    found = items(folder.summary, "/images") if folder.is_fit else []
    if len(found) > MOST_LARGE:
        return page.fit(f"{folder.name}: outlines of the images", html.paragraph(
            "Outlines of the images, blue, and of the fitted drapes, red.", "quiet") +
            html.BLOCKS.multiples([small_image(folder, image) for image in found[:MOST_TILES]]) + (
                html.paragraph(f"The first {MOST_TILES} of {len(found)} images.", "missing")
                if len(found) > MOST_TILES else ""))
    return html.BLOCKS.side_by_side([("", page.fit(text(image, "/file"), image_part(folder, image, page)))
                                     for image in found])


# Drapes from above

def read_outlines(path):
    """Name, group, drape coefficient, nodes and radii of each drape of outlines.json."""
    listed = read_json(path)
    if not isinstance(listed, dict) or (listed.get("format"), listed.get("version")) != (
            "drapefit-outlines", 1):
        raise InputError(f"{path}: expected outlines of drapes, with \"format\": \"drapefit-outlines\"")
    outlines = []
    for i, drape in enumerate(items(listed, "/drapes")):
        radius = items(drape, "/radius_m", (int, float))
        numbers = [number(drape, key) for key in ("/group", "/dc", "/folds")]
        if None in numbers or len(radius) != LISTED_ANGLES or min(radius) < 0:
            raise InputError(f"{path}: key 'drapes[{i}]': expected name, group, dc, folds and "
                             f"{LISTED_ANGLES} radii of at least 0")
        outlines.append((text(drape, "/name"), *numbers, np.array(radius)))
    return outlines


def tiles(folder, page):
    path = folder.at("outlines.json")
    if not os.path.lexists(path):
        return ""
    try:
        outlines = read_outlines(path)
    except InputError as error:
        return html.paragraph(str(error), "missing")
    if not outlines:
        return ""
    specimen, support = (500 * size for size in folder.discs() or USUAL_DISCS)  # radii [mm]
    middle = specimen + 10
    drapes = [(int(group) % COLOURS, name, svg_path(1e3 * radius, middle, middle, 0),
               "%.1f %%, %d nodes" % (100 * dc, folds))
              for name, group, dc, folds, radius in outlines[:MOST_TILES]]
    markup = html.BLOCKS.tiles(drapes, middle, [support, specimen])
    if len(outlines) > MOST_TILES:
        markup += html.paragraph(f"The first {MOST_TILES} of {len(outlines)} drapes; outlines.json has "
                                 "all.", "missing")
    return page.fit(folder.name + ": outlines of the drapes", markup)


def branches(folder):
    found = items(folder.summary, "/branches") if folder.program == "drape_equilibria" else []
    if not found:
        return ""
    rows = []
    for i, branch in enumerate(found[:MOST_BRANCHES]):
        seeds = find(branch, "/seeds")
        rows.append((html.header(f"branch {i + 1}"),
                     html.numeric(str(len(seeds) if isinstance(seeds, list) else 0)),
                     *(html.number_cell(branch, *column)
                       for column in [("/frequency", 100, "%.0f"), ("/dc", 100, "%.1f"),
                                      ("/folds", 1, "%.0f"), ("/energy_J", 1e3, "%.4f")]),
                     ("yes" if find(branch, "/stable") is True else "no", ""),
                     (text(branch, "/state"), "")))
    table = html.table(rows, ("", "drapes", "share [%]", "drape coefficient [%]", "nodes",
                              "energy [mJ]", "stable", "state"),
                       "Branches, the most frequent first; energy is of the lowest drape")
    if len(found) > MOST_BRANCHES:
        table += html.paragraph(f"The first {MOST_BRANCHES} of {len(found)} branches; summary.json has "
                                "all.", "missing")
    return table


def outlines(folder, page):
    return branches(folder) + tiles(folder, page)


def how_to_read(markup):
    return html.paragraph("One colour for each specimen or branch; below each drape its drape "
                          "coefficient and number of nodes. The circles are the support and the flat "
                          "cloth.", "quiet") if 'class="tiles"' in markup else ""


# Drapes to turn

def read_surface(path):
    """Positions [m], triangles and material coordinates [m], or else x and y, of an OBJ file."""
    lines = {"v": [], "vt": [], "f": []}
    for line in read_text(path).splitlines():
        kind, *words = line.split() or [""]
        if kind in lines:
            lines[kind].append(words)
    try:
        corners = np.array([[word.split("/") + [""] for word in words] for words in lines["f"]])
        x = np.array(lines["v"], float).reshape(-1, 3)
        faces = corners[:, :, 0].astype(int).reshape(-1, 3) - 1
        uv = x[:, :2].copy()
        if lines["vt"]:
            rest = np.array([words[:2] for words in lines["vt"]], float)
            uv[faces] = rest[corners[:, :, 1].astype(int) - 1]
        good = np.isfinite(x).all() and (0 <= faces).all()
        x[faces]
    except (ValueError, IndexError):
        good = False
    if not good:
        raise InputError(f"{path}: expected an OBJ file of triangles")
    return x, faces, uv


def read_frames(path, x):
    """The frames of a point cache PC2 of these points, or, where there is none, the points."""
    if not os.path.lexists(path):
        return x[None]
    with open_file(path) as file:
        header = file.read(32)
        points, _, _, frames = np.frombuffer(header[16:], "<i4") if len(header) == 32 else [0] * 4
        if points != len(x) or frames < 1:
            raise InputError(f"{path}: expected a point cache of {len(x)} points")
        try:
            return np.memmap(file, "<f4", "r", 32, (frames, points, 3))
        except ValueError:
            raise InputError(f"{path}: expected {frames} frames of {points} points") from None


class Cloth:
    """Frames of positions [m], material coordinates uv [m] and triangles of an OBJ file."""

    def __init__(self, path):
        x, self.faces, self.uv = read_surface(path)
        self.frames = read_frames(path[:-4] + ".pc2", x)
        a, b, c = (self.uv[self.faces[:, k]] for k in range(3))
        self.area = abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
        if not (self.area > 0).all():
            raise InputError(f"{path}: has a face without an area, expected a cloth")
        edges = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        keys, count = np.unique(edges, axis=0, return_counts=True)
        by_edge = np.lexsort((edges[:, 1], edges[:, 0]))
        start = np.cumsum(count) - count
        self.hinges = keys[count == 2]
        self.beside = np.stack([by_edge[start[count == 2] + k] // 3 for k in range(2)], axis=1)

    def sum_at(self, vertices, values):
        """The sum over faces or hinges at each vertex."""
        return np.bincount(vertices.ravel(), np.repeat(values, vertices.shape[1]), len(self.uv))

    def mean_of_faces(self, values):
        """The mean of the faces around each vertex, weighted by area."""
        area = self.sum_at(self.faces, self.area)
        return self.sum_at(self.faces, self.area * values) / np.maximum(area, 1e-30)

    def stretch(self, x):
        """The largest principal strain of the faces around each vertex, against the flat cloth [%]."""
        rest = np.stack([self.uv[self.faces[:, k]] - self.uv[self.faces[:, 0]] for k in (1, 2)], axis=2)
        edges = np.stack([x[self.faces[:, k]] - x[self.faces[:, 0]] for k in (1, 2)], axis=2)
        deformation = edges @ np.linalg.inv(rest)
        return self.mean_of_faces(100 * (np.linalg.norm(deformation, 2, axis=(1, 2)) - 1))

    def curvature(self, x):
        """The angle of each hinge over the length between the centres of its faces [1/m]."""
        a, b, c = (x[self.faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
        cosine = np.clip((normal[self.beside[:, 0]] * normal[self.beside[:, 1]]).sum(axis=1), -1, 1)
        rest = np.linalg.norm(self.uv[self.hinges[:, 0]] - self.uv[self.hinges[:, 1]], axis=1)
        value = np.arccos(cosine) / (2 * self.area[self.beside].sum(axis=1) / (3 * rest))
        count = self.sum_at(self.hinges, np.ones(len(value)))
        return self.sum_at(self.hinges, value) / np.maximum(count, 1)


def packed(values, kind):
    return base64.b64encode(np.asarray(values).astype(kind).tobytes()).decode()


def steps(values, kind="<u2"):
    """Numbers in 65,535 steps, or 255, from the least to the most, as drapes.js reads them."""
    values = np.asarray(values, float).ravel()
    least, most = values.min(), values.max()
    step = (most - least) / np.iinfo(kind).max if most > least else 1
    return {"least": least, "most": most, "steps": packed(np.rint((values - least) / step), kind)}


def packed_faces(faces, count):
    return packed(faces, "<u2" if count <= 65536 else "<u4")


def viewer_drape(path, name, folder, viewer, page):
    """A drape of the viewer. Faces are left out where they are those of its first drape."""
    mesh = Cloth(path)
    moving = [mesh.frames]
    if folder.program == "drape_garment":
        body = os.path.join(os.path.dirname(path), "body")
        x, body_faces, _ = read_surface(body + ".obj")
        moving.append(read_frames(body + ".pc2", x))
    count = min(map(len, moving))
    most = max(1, int(motion_share(page) * count))
    shown = np.unique(np.linspace(count - 1, 0, most).round()).astype(int)
    frames, *of_body = [each[shown].astype(float) for each in moving]
    if not all(np.isfinite(each).all() for each in [frames, *of_body]):
        raise InputError(f"{path}: has a point that is no number in its point cache or its body's")
    discs, faces = folder.discs(), packed_faces(mesh.faces, len(mesh.uv))
    fields = [("height", "mm", 1e3 * frames[:, :, 2]), ("stretch", "%", list(map(mesh.stretch, frames))),
              ("curvature", "1/m", list(map(mesh.curvature, frames)))]
    drape = {"name": name, "support_m": discs[1] / 2 if discs else None, "positions": steps(frames),
             "times": (shown / (number(folder.summary, "/frames_per_second") or 25)).tolist(),
             "fields": [{"name": field, "unit": unit} | steps(values, "u1")
                        for field, unit, values in fields]}
    if not viewer or viewer[0]["faces"] != faces:
        drape["faces"] = faces
    if of_body:
        body = {"positions": steps(*of_body), "faces": packed_faces(body_faces, len(x))}
        if body not in page.bodies and page.take(len(html.script_json(body)), f"{folder.name}: body"):
            page.bodies.append(body)
        drape["body"] = page.bodies.index(body) if body in page.bodies else None
    note = f"{name}: {most} of {count} frames are shown; a larger --max_mb shows more"
    return drape, note if most < count else ""


def motion_share(page):
    """The share of the frames of all motions that has room. A cloth takes as many bytes on the page
    as in its point cache, a body two thirds."""
    if page.motion_share is None:
        caches = [(folder.at(os.path.join(os.path.dirname(file), name)), weight)
                  for folder in page.folders for _, file in stored_drapes(folder)[:MOST_DRAPES]
                  for name, weight in ((os.path.basename(file)[:-4] + ".pc2", 1), ("body.pc2", 2 / 3))]
        size = sum(weight * os.lstat(path).st_size for path, weight in caches if os.path.lexists(path))
        page.motion_share = min(1, 0.9 * page.room / max(size, 1))
    return page.motion_share


def stored_drapes(folder):
    """Name and file of each drape of a folder: of branches, of garments, or its meshes."""
    if folder.program == "drape_equilibria":
        return [("branch %d, %.0f %% of the drapes" % (i + 1, 100 * (number(branch, "/frequency") or 0)),
                 f"branch_{i + 1}.obj") for i, branch in enumerate(items(folder.summary, "/branches"))]
    if folder.program == "drape_garment":
        count = len(items(folder.summary, "/runs"))
        return [("garment", "garment.obj")] if count == 1 else [
            (f"draw {i + 1}", f"draw_{i + 1}/garment.obj") for i in range(count)]
    if folder.program not in ("drape_fit", "drape_simulate", "drape_predict"):
        return []
    return [(file[:-4].removeprefix("drape_"), file) for file in folder.files(".obj")]


def drapes(folder, page):
    viewer, missing = [], []
    stored = stored_drapes(folder)
    for name, file in stored[:MOST_DRAPES]:
        try:
            drape, note = viewer_drape(folder.at(file), name, folder, viewer, page)
        except InputError as error:
            note = str(error)
        else:
            if page.take(len(html.script_json(drape)), f"{folder.name}: drape {name}"):
                viewer.append(drape)
        missing += [html.paragraph(note, "missing")] if note else []
    if len(viewer) < len(stored):
        missing.append(html.paragraph(f"{len(viewer)} of {len(stored)} drapes are shown", "missing"))
    if not viewer:
        return html.join(missing)
    page.drapes.append(viewer)
    side_by_side = 2 if folder.program == "drape_garment" and len(viewer) > 1 else 1
    return html.BLOCKS.viewers(len(page.drapes) - 1, side_by_side) + html.join(missing)


def how_to_turn(markup):
    return html.paragraph("The drape in three dimensions needs a script.", "quiet unscripted") + (
        html.paragraph("Drag or use the arrow keys to turn, the wheel or two fingers to zoom. Stretch "
                       "is the largest principal strain against the flat cloth. Motions play in "
                       "step; a GLB file has the motion for other programs.", "quiet")
    ) if markup else ""
