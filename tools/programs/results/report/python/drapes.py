# SPDX-License-Identifier: Apache-2.0
"""Images and drapes: outlines as layers over the image, drapes from above, drapes to turn."""

import base64
import os

import numpy as np
import PIL.Image

import page as html
from results import (InputError, coefficient_text, decode_picture, find, items, number, number_text,
                     read_bytes, read_json, read_text, text, texts)

ANGLES = 2 * np.pi * np.arange(360) / 360
MOST_DRAPES, MOST_TILES, MOST_BRANCHES = 12, 96, 30  # of one folder
LISTED_ANGLES = 120  # of outlines.json
COLOURS = 7  # of style.css
USUAL_DISCS, USUAL_SCALE = (0.30, 0.18), 719.5  # diameters [m], px/m


# Images and outlines

def read_coverage(path):
    """The share of each pixel that is cloth, and the bytes of the file."""
    data = read_bytes(path)
    picture = decode_picture(path, data)
    if picture.mode in ("RGBA", "LA", "P"):
        picture = picture.convert("RGBA")
        picture = PIL.Image.alpha_composite(PIL.Image.new("RGBA", picture.size, "white"), picture)
    return 1 - np.asarray(picture.convert("L"), float) / 255, data


def stretch_levels(coverage):
    """Background and cloth of a photograph at 0 and 1, by the classes of Otsu's threshold."""
    count = np.bincount(np.rint(255 * coverage).astype(int).ravel(), minlength=256)
    levels = np.arange(256) / 255
    below, sums = np.cumsum(count)[:-1], np.cumsum(count * levels)
    above = count.sum() - below
    low = sums[:-1] / np.maximum(below, 1)
    high = (sums[-1] - sums[:-1]) / np.maximum(above, 1)
    best = np.argmax(below * above * (high - low) ** 2)
    return np.clip((coverage - low[best]) / max(high[best] - low[best], 1e-9), 0, 1)


def part_of(mask, seed):
    """The connected part of a mask that holds the seed, grown by whole runs of rows and columns."""
    grown = np.zeros_like(mask)
    grown[seed] = mask[seed]
    count = 0
    while grown.sum() != count:
        count = grown.sum()
        for _ in range(2):
            starts = np.cumsum(mask & ~np.pad(mask, ((0, 0), (1, 0)))[:, :-1], axis=None)
            runs = starts.reshape(mask.shape)
            reached = np.bincount(runs[grown], minlength=runs.max() + 1) > 0
            grown, mask = (mask & reached[runs]).T, mask.T
    return grown


def only_cloth(coverage, camera):
    """The coverage without parts beside the cloth."""
    mask = coverage >= 0.5
    rows, columns = np.nonzero(mask)
    if len(rows) == 0:
        return coverage
    nearest = np.argmin((rows - camera["cy"]) ** 2 + (columns - camera["cx"]) ** 2)
    cloth = part_of(mask, (rows[nearest], columns[nearest]))
    return np.where(mask & ~cloth, 0, coverage)


def along_ray(image, cx, cy, radius):
    """The coverage at this distance on each ray, between pixels by their distance."""
    x, y = cx + radius * np.cos(ANGLES), cy - radius * np.sin(ANGLES)
    c, r = np.floor(x).astype(int), np.floor(y).astype(int)
    inside = (c >= 0) & (r >= 0) & (c < image.shape[1] - 1) & (r < image.shape[0] - 1)
    c, r = np.where(inside, c, 0), np.where(inside, r, 0)
    u, v = x - c, y - r
    value = ((1 - v) * ((1 - u) * image[r, c] + u * image[r, c + 1]) +
             v * ((1 - u) * image[r + 1, c] + u * image[r + 1, c + 1]))
    return np.where(inside, value, 0)


def outline_of_image(image, camera):
    """The outermost radius on each ray at which half of a pixel is cloth [px]."""
    cx, cy, step = camera["cx"], camera["cy"], 0.25
    reach = np.hypot(max(cx, image.shape[1] - cx), max(cy, image.shape[0] - cy))
    radius, outer = np.zeros(len(ANGLES)), np.zeros(len(ANGLES))
    for i in range(int(np.ceil(reach / step)), -1, -1):
        value = along_ray(image, cx, cy, step * i)
        met = (radius == 0) & (value >= 0.5)
        with np.errstate(invalid="ignore", divide="ignore"):
            radius = np.where(met, step * i + step * (value - 0.5) / (value - outer), radius)
        outer = value
    return radius


def project(camera, x):
    """Column and row of points that drape_fit has written for a camera with a centred image."""
    scale = camera["px_per_m"]
    centred = x[:, :2] + [-(camera["cx"] - (camera["width"] - 1) / 2) / scale,
                          (camera["cy"] - (camera["height"] - 1) / 2) / scale]
    size, eye = np.full(len(x), scale), np.zeros(2)
    if camera["kind"] == "pinhole":
        focal = camera["height"] / 2 / np.tan(camera["field_of_view_rad"] / 2)
        size = focal / (camera["eye_height_m"] - x[:, 2])
        eye = np.array([camera.get("eye_x_m", 0), camera.get("eye_y_m", 0)])
    moved = size[:, None] * centred + (scale - size)[:, None] * eye
    return moved * [1, -1] + [camera["cx"], camera["cy"]]


def outline_of_mesh(mesh, camera):
    """The outermost crossing of each ray with the projected hem [px]."""
    points = (project(camera, mesh.x) - [camera["cx"], camera["cy"]]) * [1, -1]
    a, b = points[mesh.hem[:, 0]], points[mesh.hem[:, 1]]
    ray = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)[:, None, :]
    edge = b - a
    turn = ray[..., 0] * edge[:, 1] - ray[..., 1] * edge[:, 0]
    with np.errstate(invalid="ignore", divide="ignore"):
        radius = (a[:, 0] * edge[:, 1] - a[:, 1] * edge[:, 0]) / turn
        t = (a[:, 0] * ray[..., 1] - a[:, 1] * ray[..., 0]) / turn
    return np.where((radius > 0) & (t >= 0) & (t <= 1), radius, 0).max(axis=1)


def svg_path(radius, cx, cy, digits=2):
    angles = 2 * np.pi * np.arange(len(radius)) / len(radius)
    form = f"%.{digits}f %.{digits}f"
    return "M" + "L".join(form % point for point in zip(cx + radius * np.cos(angles),
                                                        cy - radius * np.sin(angles))) + "Z"


def read_camera(image, where):
    """The camera of an image, with every number that its projection needs."""
    camera = find(image, "/camera")
    keys = ["width", "height", "cx", "cy"]
    if isinstance(camera, dict):
        pinhole = camera.get("kind") == "pinhole"
        keys += ["eye_height_m", "field_of_view_rad"] if pinhole else ["px_per_m"]
        known = all(number(camera, "/" + key) is not None for key in keys)
        if known and all(0 <= camera[c] < camera[size] for c, size in (("cx", "width"), ("cy", "height"))):
            focal = (camera["height"] / 2 / np.tan(camera["field_of_view_rad"] / 2) /
                     camera["eye_height_m"] if pinhole else 0)
            return {"px_per_m": focal} | camera
    raise InputError(f"{where}: has no camera in the summary, expected {', '.join(keys)}")


def layers(folder, image, page):
    file = text(image, "/file")
    camera = read_camera(image, file)
    if folder.changed(file):
        raise InputError(f"{file}: is not the file that was fitted: it has changed since")
    coverage, data = read_coverage(file)
    if coverage.shape != (camera["height"], camera["width"]):
        raise InputError(f"{file}: has another size than the fit's image")
    if find(image, "/quality/photograph") is True:
        coverage = stretch_levels(coverage)
    if number(image, "/quality/cut_px"):
        coverage = only_cloth(coverage, camera)
    mesh = Mesh(folder.at(f"drape_{text(image, '/name')}.obj"))
    cx, cy = camera["cx"] + 0.5, camera["cy"] + 0.5
    paths = [("image", svg_path(outline_of_image(coverage, camera), cx, cy)),
             ("fitted", svg_path(outline_of_mesh(mesh, camera), cx, cy))]
    uri = html.uri("jpeg" if data.startswith(b"\xff\xd8") else "png", data)
    specimen, support = folder.discs() or USUAL_DISCS
    rings = [(cx, cy, size / 2 * camera["px_per_m"]) for size in (support, specimen)]
    return html.BLOCKS.layers(camera["width"], camera["height"],
                              f"Outline of {file} and of the fitted drape",
                              uri if page.take(len(uri), file) else "", paths, rings,
                              0.05 * camera["px_per_m"])


def stored_overlay(folder, name, reason, page):
    """The picture that the fit wrote, of an image that can no longer be read."""
    file = folder.at(f"fit_{name}.png")
    if not os.path.lexists(file):
        return html.paragraph(reason, "missing")
    return page.picture(file, "Outlines of the image, blue, and of the fit, red", reason)


def image_metrics(image):
    px_per_mm = 1e-3 * (number(image, "/camera/px_per_m") or USUAL_SCALE)

    def row(name, seen, fitted):
        return html.header(name), html.numeric(seen), html.numeric(fitted)
    rows = [row("drape coefficient [%]", number_text(image, "/metrics/dc_image", 100, "%.1f"),
                number_text(image, "/metrics/dc_fit", 100, "%.1f"))]
    if find(image, "/photograph"):
        rows.append(row("the photograph's, ± standard deviation [%]",
                        coefficient_text(image["photograph"]), ""))
    rows.append(row("nodes", number_text(image, "/metrics/folds_image", 1, "%.0f"),
                    number_text(image, "/metrics/folds_fit", 1, "%.0f")))
    rows += [row(name, "", number_text(image, pointer, factor, form)) for name, pointer, factor, form in [
        ("outline error, rms [mm]", "/metrics/profile_rms_px", 1 / px_per_mm, "%.2f"),
        ("the same after settling [mm]", "/settled/metrics/profile_rms_px", 1 / px_per_mm, "%.2f"),
        ("overlap of the areas (IoU) [%]", "/metrics/iou", 100, "%.1f"),
        ("lowest vibration [Hz]", "/stability/lowest_frequency_hz", 1, "%.2f")]]
    return html.table(rows, ("", "image", "fit"))


def image_part(folder, image, page):
    name = text(image, "/name")
    try:
        picture = layers(folder, image, page)
    except InputError as error:
        picture = stored_overlay(folder, name, str(error), page)
    notes = html.join(html.paragraph(note, "quiet") for note in texts(image, "/quality/notes"))
    return html.BLOCKS.columns(html.paragraph(name, "quiet") + picture, image_metrics(image) + notes)


def add_images(folders, page):
    def part(folder):
        images = items(folder.summary, "/images") if folder.is_fit else []
        return html.BLOCKS.side_by_side([("", page.fit(text(image, "/file"), image_part(folder, image, page)))
                                         for image in images])
    page.add("images", "Image and fit", page.side_by_side(folders, part))


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
                     *(html.numeric(number_text(branch, pointer, factor, form))
                       for pointer, factor, form in [("/frequency", 100, "%.0f"), ("/dc", 100, "%.1f"),
                                                     ("/folds", 1, "%.0f"),
                                                     ("/energy_J", 1e3, "%.4f")]),
                     ("yes" if find(branch, "/stable") is True else "no", ""),
                     (text(branch, "/state"), "")))
    table = html.table(rows, ("", "drapes", "share [%]", "drape coefficient [%]", "nodes",
                              "energy [mJ]", "stable", "state"),
                       "Branches, the most frequent first; energy is of the lowest drape")
    if len(found) > MOST_BRANCHES:
        table += html.paragraph(f"The first {MOST_BRANCHES} of {len(found)} branches; summary.json has "
                                "all.", "missing")
    return table


def add_outlines(folders, page):
    markup = page.side_by_side(folders, lambda folder: branches(folder) + tiles(folder, page))
    if 'class="tiles"' in markup:
        markup = html.paragraph("One colour for each specimen or branch; below each drape its drape "
                                "coefficient and number of nodes. The circles are the support and the "
                                "flat cloth.", "quiet") + markup
    page.add("outlines", "Drapes from above", markup)


# Drapes to turn

class Mesh:
    """Positions x [m], material coordinates uv [m] and triangles of an OBJ file."""

    def __init__(self, path):
        lines = {"v": [], "vt": [], "f": []}
        for line in read_text(path).splitlines():
            kind, *words = line.split() or [""]
            if kind in lines:
                lines[kind].append(words)
        try:
            corners = np.array([[word.split("/") + [""] for word in words] for words in lines["f"]])
            self.x = np.array(lines["v"], float).reshape(-1, 3)
            self.faces = corners[:, :, 0].astype(int).reshape(-1, 3) - 1
            self.uv = self.x[:, :2].copy()
            if lines["vt"]:
                rest = np.array([words[:2] for words in lines["vt"]], float)
                self.uv[self.faces] = rest[corners[:, :, 1].astype(int) - 1]
            good = np.isfinite(self.x).all() and (0 <= self.faces).all()
            self.x[self.faces]
        except (ValueError, IndexError):
            good = False
        if not good:
            raise InputError(f"{path}: expected an OBJ file of triangles")
        a, b, c = (self.uv[self.faces[:, k]] for k in range(3))
        self.area = abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
        if not (self.area > 0).all():
            raise InputError(f"{path}: has a face without an area, expected a cloth")
        edges = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        keys, count = np.unique(edges, axis=0, return_counts=True)
        self.hem = keys[count == 1]
        by_edge = np.lexsort((edges[:, 1], edges[:, 0]))
        start = np.cumsum(count) - count
        self.hinges = keys[count == 2]
        self.beside = np.stack([by_edge[start[count == 2] + k] // 3 for k in range(2)], axis=1)

    def mean_of_faces(self, values):
        """The mean of the faces around each vertex, weighted by area."""
        total, area = np.zeros(len(self.x)), np.zeros(len(self.x))
        np.add.at(total, self.faces, (self.area * values)[:, None])
        np.add.at(area, self.faces, self.area[:, None])
        return total / np.maximum(area, 1e-30)

    def stretch(self):
        """The largest principal strain of each face against its rest shape [%]."""
        rest = np.stack([self.uv[self.faces[:, k]] - self.uv[self.faces[:, 0]] for k in (1, 2)], axis=2)
        edges = np.stack([self.x[self.faces[:, k]] - self.x[self.faces[:, 0]] for k in (1, 2)], axis=2)
        deformation = edges @ np.linalg.inv(rest)
        return 100 * (np.linalg.svd(deformation, compute_uv=False)[:, 0] - 1)

    def curvature(self):
        """The angle of each hinge over the length between the centres of its faces [1/m]."""
        a, b, c = (self.x[self.faces[:, k]] for k in range(3))
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1), 1e-30)[:, None]
        cosine = np.clip((normal[self.beside[:, 0]] * normal[self.beside[:, 1]]).sum(axis=1), -1, 1)
        rest = np.linalg.norm(self.uv[self.hinges[:, 0]] - self.uv[self.hinges[:, 1]], axis=1)
        value = np.arccos(cosine) / (2 * self.area[self.beside].sum(axis=1) / (3 * rest))
        total, count = np.zeros(len(self.x)), np.zeros(len(self.x))
        np.add.at(total, self.hinges, value[:, None])
        np.add.at(count, self.hinges, 1)
        return total / np.maximum(count, 1)


def packed(values, kind):
    return base64.b64encode(np.asarray(values).astype(kind).tobytes()).decode()


def steps(values):
    """Numbers in 65,535 steps from the least to the most, as drapes.js reads them."""
    values = np.asarray(values, float).ravel()
    least, most = values.min(), values.max()
    step = (most - least) / 65535 if most > least else 1
    return {"least": least, "most": most, "steps": packed(np.rint((values - least) / step), "<u2")}


def viewer_drape(path, name, folder, viewer):
    """A drape of the viewer. Faces are left out where they are those of its first drape."""
    mesh = Mesh(path)
    discs = folder.discs()
    fields = [("height", "mm", 1e3 * mesh.x[:, 2]),
              ("stretch", "%", mesh.mean_of_faces(mesh.stretch())), ("curvature", "1/m", mesh.curvature())]
    drape = {"name": name, "support_m": discs[1] / 2 if discs else None, "positions": steps(mesh.x),
             "fields": [{"name": field, "unit": unit} | steps(values) for field, unit, values in fields]}
    faces = packed(mesh.faces, "<u2" if len(mesh.x) <= 65536 else "<u4")
    if not viewer or viewer[0]["faces"] != faces:
        drape["faces"] = faces
    return drape


def stored_drapes(folder):
    """Name and file of each drape: meshes of drape_fit, drape_simulate, drape_predict, branches."""
    if folder.program == "drape_equilibria":
        return [("branch %d, %.0f %% of the drapes" % (i + 1, 100 * (number(branch, "/frequency") or 0)),
                 f"branch_{i + 1}.obj") for i, branch in enumerate(items(folder.summary, "/branches"))]
    if folder.program not in ("drape_fit", "drape_simulate", "drape_predict"):
        return []
    return [(file[:-4].removeprefix("drape_"), file) for file in folder.files(".obj")]


def drapes(folder, page):
    viewer, missing = [], []
    stored = stored_drapes(folder)
    for name, file in stored[:MOST_DRAPES]:
        try:
            drape = viewer_drape(folder.at(file), name, folder, viewer)
        except InputError as error:
            missing.append(html.paragraph(str(error), "missing"))
            continue
        if page.take(len(html.script_json(drape)), f"{folder.name}: drape {name}"):
            viewer.append(drape)
    if len(viewer) < len(stored):
        missing.append(html.paragraph(f"{len(viewer)} of {len(stored)} drapes are shown", "missing"))
    if not viewer:
        return html.join(missing)
    page.drapes.append(viewer)
    return html.BLOCKS.viewer(len(page.drapes) - 1) + html.join(missing)


def add_drapes(folders, page):
    markup = page.side_by_side(folders, lambda folder: drapes(folder, page))
    if markup:
        markup = html.join([
            html.paragraph("The drape in three dimensions needs a script.", "quiet unscripted"),
            html.paragraph("Drag or use the arrow keys to turn, the wheel or two fingers to zoom. "
                           "Stretch is the largest principal strain against the flat cloth.", "quiet"),
            markup])
    page.add("drape", "Drape in three dimensions", markup)
