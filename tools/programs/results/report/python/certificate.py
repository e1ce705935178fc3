# SPDX-License-Identifier: Apache-2.0
"""The first page of a report: a certificate of each fabric for one sheet of paper, and the
comparison of fabrics."""

import io
import math
import os

import PIL.Image

import page as html
from drapes import USUAL_DISCS, image_outlines
from results import (InputError, decode_picture, find, find_photograph, items, number, number_text,
                     read_bytes, read_folder, text, texts)
from verdict import LAMPS, LOOKS, is_measured, rows_of_material, sizes_text

PICTURE_SIDE, MARGIN = 640, 0.06  # [px]; around the flat specimen, of its diameter
UNKNOWN = "unknown"
FACTS = ("customer", "operator", "date", "sample")
BENDING = ("bending_length_overall_cm", "bending_overall_un_m", "bending_in_drape_un_m")


def stem(path):
    return os.path.splitext(os.path.basename(path))[0]


def photographed(fit, samples, pictures):
    """The results of drape_photo of the first picture that has them."""
    for picture in pictures:
        folder = samples.at(os.path.dirname(text(picture, "/file")))
        if samples.program == "drape_photo" and os.path.isdir(folder):
            return read_folder(folder)
    images = items(fit.summary, "/images") if fit else []
    return next(filter(None, map(find_photograph, images)), None)


def photograph(folder, page):
    """The photograph cropped to the flat specimen, with the outline that was found in it."""
    box = items(folder.summary, "/specimen_in_overlay_px", (int, float)) if folder else []
    if len(box) != 4 or min(box[2:]) <= 0:
        return ""
    path = folder.at("overlay.png")
    edge = MARGIN * max(box[2:])
    left, top, width, height = box
    crop = decode_picture(path, read_bytes(path)).convert("RGB").crop(
        tuple(round(side) for side in (left - edge, top - edge, left + width + edge, top + height + edge)))
    scale = min(1, PICTURE_SIDE / max(crop.size))
    crop = crop.resize([max(1, round(scale * side)) for side in crop.size], PIL.Image.Resampling.LANCZOS)
    data = io.BytesIO()
    crop.save(data, "JPEG", quality=85)
    px_per_m = scale * max(width, height) / (folder.discs() or USUAL_DISCS)[0]
    return page.fit("the photograph of " + folder.name, html.BLOCKS.specimen(
        (0, 0, *crop.size), crop.size, html.uri("jpeg", data.getvalue()), [], [], 0.05 * px_per_m))


def silhouette(fit, page):
    images = items(fit.summary, "/images") if fit else []
    try:
        return page.fit("the outline of " + fit.name, html.BLOCKS.specimen(
            *image_outlines(fit, images[0], page, ("image",)))) if images else ""
    except InputError as error:
        return html.paragraph(str(error), "missing")


def interval(low, high, form="%.1f"):
    return UNKNOWN if None in (low, high) else f"{form % low} … {form % high}"


def mean_text(group):
    deviation = number(group, "/dc_sd_percent")
    return "%.1f" % group["dc_percent"] + (
        ", sd unknown" if deviation is None else " ± %.1f" % deviation)


def count_text(group):
    count = int(number(group, "/n") or 0)
    return f"{count} {text(group, '/of')[:-1 if count == 1 else None]}"


def nodes_text(group):
    return " or ".join(", ".join(map(str, items(group, "/nodes", int))).rsplit(", ", 1))


GROUP_COLUMNS = ("mean ± sd", "n", "90 % interval", "nodes")


def group_cells(group):
    return [html.numeric(each) for each in (mean_text(group), count_text(group), interval(
        number(group, "/dc_low_percent"), number(group, "/dc_high_percent")), nodes_text(group))]


def face_rows(groups):
    return [[html.header("face " + text(group, "/face") if text(group, "/face") else
                         "all faces" if len(groups) > 1 else "DC"), *group_cells(group)]
            for group in groups]


def groups_of_fit(fit):
    """The group of the images of a fit that no table of samples sums up."""
    images = items(fit.summary, "/images")
    measured = [number(image, "/photograph/dc") or number(image, "/metrics/dc_image") for image in images]
    if not images or None in measured:
        return []
    nodes = sorted(int(number(image, "/metrics/folds_image") or 0) for image in images)
    most = max(map(nodes.count, nodes))
    return [{"dc_percent": 100 * sum(measured) / len(measured), "n": len(images), "of": "pictures",
             "nodes": sorted({each for each in nodes if nodes.count(each) == most})}]


def bending_rows(fit):
    rows = rows_of_material(fit.summary) if fit else {}
    return [rows[key] for key in BENDING if key in rows and is_measured(rows[key])]


def bending_text(row):
    value, ends = number(row, "/value"), interval(number(row, "/low"), number(row, "/high"), "%.3g")
    return (text(row, "/text") if value is None else "%.3g" % value) + f" {text(row, '/unit')}" + (
        "" if ends == UNKNOWN else f" (90 %: {ends})") + text(row, "/source").removeprefix("measured")


def not_measured(fit):
    return [text(row, "/name") for key, row in rows_of_material(fit.summary).items()
            if text(row, "/source") == "from the prior" and not key.startswith(("kes_", "fast_"))]


def name_of(fit):
    """The picture, or the folder of the fit of several."""
    images = items(fit.summary, "/images")
    photo = find_photograph(images[0])
    return fit.name if len(images) > 1 else stem(text(photo.summary, "/photo")) if photo else text(
        images[0], "/name")


class Certificate:
    def __init__(self, name, groups, pictures, samples, fit):
        self.name, self.groups, self.pictures, self.samples, self.fit = name, groups, pictures, samples, fit

    def fact(self, key):
        return ", ".join(dict.fromkeys(filter(None, (text(each, "/" + key) for each in self.pictures))))

    def facts(self, photo):
        source = self.fit or photo or self.samples
        build = find(source.summary, "/provenance/build") or {}
        discs = source.discs() or (photo.discs() if photo else None) or USUAL_DISCS
        mass = rows_of_material(self.fit.summary).get("mass_g_per_m2") if self.fit else None
        measured = sum(not text(each, "/error") for each in self.pictures) or len(
            items(source.summary, "/images"))
        rows = [("fabric", self.name), *((key, self.fact(key)) for key in FACTS),
                ("mass by area", f"{text(mass, '/text')} g/m², {text(mass, '/source')}" if mass else ""),
                ("specimen", sizes_text(discs)), ("pictures", f"{measured} measured" + (
                    f" of {len(self.pictures)}" if len(self.pictures) > measured else "")),
                ("standard", "drape test with a circular specimen, BS 5058 and ISO 9073-9"),
                ("method", "vertical projection of the outline in a picture" + (
                    "; bending by a fit of simulated drapes" if self.fit else "")),
                ("program", f"drapefit {text(build, '/drapefit')}, commit {text(build, '/commit')[:8]}"
                 if build else "")]
        return [(key, value) for key, value in rows if value]

    def notes(self):
        """What could not be measured of this fabric, and what holds for all samples."""
        general = texts(self.samples.summary, "/samples/notes") if self.samples else []
        return [f"not measured: {text(each, '/file')}: {text(each, '/error')}"
                for each in self.pictures if text(each, "/error")] + [
                    note for note in general if not note.startswith("not measured: ")]

    def markup(self, page):
        photo = photographed(self.fit, self.samples, self.pictures)
        lamps = [(LOOKS.get(text(self.fit.summary, f"/verdict/lamps/{lamp}/grade"), "bad"),
                  f"{name}: " + (text(self.fit.summary, f"/verdict/lamps/{lamp}/grade") or "no verdict"))
                 for lamp, name in LAMPS.items()] if self.fit else []
        faces = html.table(face_rows(self.groups), ("", *GROUP_COLUMNS), "Drape coefficient [%]") if self.groups else ""
        bending = [(text(row, "/name"), bending_text(row)) for row in bending_rows(self.fit)]
        return html.BLOCKS.certificate(
            self.name, self.facts(photo), photograph(photo, page) or silhouette(self.fit, page), faces,
            bending, lamps, not_measured(self.fit) if self.fit else [], self.notes())


def certificates(folders):
    """Those of the fabrics of all samples, and of the fits of other images."""
    found, used = [], set()
    fits = [folder for folder in folders if folder.is_fit and items(folder.summary, "/images")]
    for samples in folders:
        pictures, groups = (items(samples.summary, "/samples/" + part) for part in ("pictures", "groups"))
        for fabric in dict.fromkeys(text(group, "/fabric") for group in groups):
            own = [each for each in pictures if text(each, "/fabric") == fabric]
            names = {stem(text(each, "/file")) for each in own}
            fit = next((each for each in fits if names >= {
                text(image, "/name") for image in items(each.summary, "/images")}), None)
            used.add(id(fit))
            found.append(Certificate(fabric or "fabric", [
                group for group in groups if text(group, "/fabric") == fabric
                and not text(group, "/sample") + text(group, "/specimen")], own, samples, fit))
    return found + [Certificate(name_of(fit), groups_of_fit(fit), [], None, fit)
                    for fit in fits if id(fit) not in used]


def ratio_text(a, b):
    """How much stiffer one fabric is than another, whose errors are independent."""
    rows = [next((row for row in bending_rows(each.fit) if text(row, "/key") == "bending_overall_un_m"),
                 None) for each in (a, b)]
    values = [[number(row, "/" + key) for key in ("value", "low", "high")] for row in rows]
    if None in values[0] + values[1]:
        return ""
    if values[0][0] < values[1][0]:
        a, b, values = b, a, values[::-1]
    (x, x_low, x_high), (y, y_low, y_high) = values
    low, high = (x / y * math.exp(sign * math.hypot(math.log(x / end), math.log(y / other)))
                 for sign, end, other in ((-1, x_low, y_high), (1, x_high, y_low)))
    condition = max(text(row, "/source").removeprefix("measured") for row in rows)
    ratio = "%.2g times (90 %%: %.2g … %.2g)" % (x / y, low, high)
    return (f"the bending rigidity of {a.name} is {ratio} that of {b.name}" if low > 1 else
            f"the bending rigidity of {a.name} is not distinguished from that of {b.name}: the ratio is "
            + ratio.replace(" times", "")) + condition


def comparison(found, folders):
    """The fabrics side by side, and their differences in words."""
    columns = []
    for each in found:
        bending = {text(row, "/key"): row for row in bending_rows(each.fit)}
        columns.append((group_cells(each.groups[-1]) if each.groups else [html.numeric(UNKNOWN)] * 4) + [
            html.numeric(bending_text(bending[key]) if key in bending else UNKNOWN) for key in BENDING[:2]])
    names = ("DC, mean ± sd [%]", "n", "DC, 90 % interval [%]", "nodes", "bending length c",
             "bending rigidity B")
    rows = [(html.header(name), *row) for name, *row in zip(names, *columns)]
    sentences = [text(each, "/text") for folder in folders
                 for each in items(folder.summary, "/samples/differences")]
    sentences += filter(None, (ratio_text(a, b) for i, a in enumerate(found) for b in found[i + 1:]))
    fabrics = [each.name for each in found]
    return html.BLOCKS.comparison(fabrics, html.table(rows, ("", *fabrics)), sentences)


def add_first_page(folders, page):
    """Adds the certificates and the comparison. Returns the names of the fabrics."""
    found = certificates(folders)
    page.add("certificate", "Certificate" + "s" * (len(found) > 1),
             html.join(each.markup(page) for each in found))
    if len(found) > 1:
        page.add("comparison", "Comparison", comparison(found, folders))
    page.folds = bool(found)
    return [each.name for each in found]
