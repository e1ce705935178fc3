# SPDX-License-Identifier: Apache-2.0
"""Photographs, measured drapes, fabrics for other programs, charts and tables of studies, and where
results are from."""

import math
import os
import re

import page as html
from certificate import GROUP_COLUMNS, group_cells
from results import (InputError, coefficient_text, directions, find, find_photograph, items, number,
                     number_text, read_text, text, texts, value_text)
from verdict import laboratory_sheet

DRAPE_COLUMNS = [("/shape/dc", "drape coefficient [%]", 100, "%.1f"),
                 ("/shape/folds", "nodes", 1, "%.0f"),
                 ("/area_m2", "area [cm²]", 1e4, "%.1f"),
                 ("/shape/radius_min_m", "smallest radius [mm]", 1e3, "%.1f"),
                 ("/shape/radius_max_m", "largest radius [mm]", 1e3, "%.1f")]


def photograph(folder, page):
    s = folder.summary
    rows = [(html.header("drape coefficient, ± standard deviation [%]"),
             html.numeric(coefficient_text(s)))] + html.number_rows(s, [
                 ("the same without a model of the camera [%]", "/dc_without_camera_model", 100, "%.1f"),
                 ("nodes", "/folds", 1, "%.0f"),
                 ("smallest radius [mm]", "/radius_min_m", 1e3, "%.1f"),
                 ("largest radius [mm]", "/radius_max_m", 1e3, "%.1f"),
                 ("camera above the support [m]", "/camera/eye_height_m", 1, "%.2f"),
                 ("its tilt [degrees]", "/tilt_rad", 180 / math.pi, "%.1f"),
                 ("scale [px/m]", "/camera/px_per_m", 1, "%.0f"),
                 ("error of the marker's outline, rms [px]", "/marker_rms_px", 1, "%.2f"),
                 ("marker seen [%]", "/marker_seen_share", 100, "%.0f"),
                 ("blur of the hem [mm]", "/blur_m", 1e3, "%.1f"),
                 ("specimen [cm]", "/specimen_diameter_m", 100, "%.0f"),
                 ("support [cm]", "/support_diameter_m", 100, "%.0f")])
    picture = ""
    if os.path.lexists(folder.at("overlay.png")):
        picture = page.picture(folder.at("overlay.png"),
                               "The photograph with the outline and the disc that were found",
                               text(s, "/photo"))
    known = [row for row in rows if row[1] != html.numeric("none")]
    return html.BLOCKS.columns(picture, html.table(known, ("", "found")))


def fit_photographs(fit, page):
    """The photographs that a fit is of, without those that have a column of their own or are among
    samples."""
    own = {os.path.realpath(folder.path) for folder in page.folders}
    found = [find_photograph(image) for image in items(fit.summary, "/images")]
    paths = {each.name: os.path.realpath(each.path) for each in found if each}
    return html.join(photograph(each, page) for each in found
                     if each and not {paths[each.name], os.path.dirname(paths[each.name])} & own)


def samples(s):
    """The means of all groups."""
    rows = [[html.header(text(group, "/fabric")), *((text(group, "/" + key) or "all", "")
                                                    for key in ("sample", "specimen", "face")),
             *group_cells(group)] for group in items(s, "/samples/groups")]
    return html.table(rows, ("fabric", "sample", "specimen", "face", *GROUP_COLUMNS),
                      "Drape coefficient [%]")


def measured_row(drape):
    error = text(drape, "/error")
    notes = ["not measured: " + error] if error else []
    return [html.header(text(drape, "/file")),
            *(html.number_cell(drape, pointer, *rest) for pointer, _, *rest in DRAPE_COLUMNS),
            ("; ".join(notes + texts(drape, "/quality/notes")), "")]


def measured(drapes):
    most = 500
    table = html.table([measured_row(drape) for drape in drapes[:most]],
                       ["file", *(name for _, name, _, _ in DRAPE_COLUMNS), "notes"])
    sheets = html.join(html.details(text(drape, "/file"), laboratory_sheet(drape["laboratory"]))
                       for drape in drapes[:most] if isinstance(drape.get("laboratory"), dict))
    left = html.paragraph(f"the first {most} of {len(drapes)} drapes", "missing")
    return table + sheets + (left if len(drapes) > most else "")


def compared(pair):
    rows = html.number_rows(pair, [
        (name, (f"/raw/{key}", f"/aligned/{key}"), factor, form) for name, key, factor, form in [
            ("outline, rms [mm]", "outline_rms_m", 1e3, "%.2f"),
            ("outline, Hausdorff [mm]", "outline_hausdorff_m", 1e3, "%.2f"),
            ("silhouettes, IoU [%]", "iou", 100, "%.1f"),
            ("silhouettes, MSE", "mse", 1, "%.4f"),
            ("surfaces, Hausdorff [mm]", "surface_hausdorff_m", 1e3, "%.2f")]
        if key != "surface_hausdorff_m" or find(pair, "/raw/" + key) is not None])
    columns = [column for column in DRAPE_COLUMNS if column[0] != "/area_m2"]
    shapes = [(html.header(side.upper()), *(html.number_cell(find(pair, "/" + side), pointer, *rest)
                                            for pointer, _, *rest in columns)) for side in "ab"]
    return (html.table(rows, ("difference", "as they lie", "aligned"),
                       f"A {text(pair, '/a/file')}, B {text(pair, '/b/file')}") +
            html.table(shapes, ["", *(name for _, name, _, _ in columns)]))


def metrics(s):
    if "drapes" in s:
        return measured(items(s, "/drapes"))
    if "shape" in s:
        return measured([s])
    if "raw" in s:
        return compared(s)
    return html.flat_table({key: s[key] for key in s if key != "provenance"})


def measurement(folder, page):
    found = page.fit(folder.name, samples(folder.summary)) if "samples" in folder.summary else ""
    if folder.program == "drape_photo":
        return found or photograph(folder, page)
    if folder.program == "drape_metrics":
        return found + page.fit(folder.name, metrics(folder.summary))
    return fit_photographs(folder, page) if folder.is_fit else ""


def linear_record(record):
    rows = []
    warp, weft = directions(record)
    for key, name, factor, unit in [
            ("bend_" + warp, "bending rigidity, " + warp, 1e6, "µN·m"),
            ("bend_" + weft, "bending rigidity, " + weft, 1e6, "µN·m"),
            ("bend_bias", "bending rigidity, bias", 1e6, "µN·m"),
            ("c11", f"tensile stiffness, {weft} (c11)", 1, "N/m"),
            ("c22", f"tensile stiffness, {warp} (c22)", 1, "N/m"),
            ("c12", f"coupling of {warp} and {weft} (c12)", 1, "N/m"),
            ("shear", "shear rigidity G", 1, "N/m")]:
        found = find(record, "/linear/" + key)
        if found:
            ends = [number_text(found, end, factor, "%.3g") for end in ("/low", "/high")]
            value = number_text(found, "/value", factor)
            if value == "none" and ends != ["none", "none"]:
                value = "at least " + ends[0] if ends[1] == "none" else "at most " + ends[1]
            rows.append((html.header(name), html.numeric(value),
                         html.numeric("" if "none" in ends else " … ".join(ends)), (unit, ""),
                         html.origin(text(found, "/source"))))
    return html.table(rows, ("quantity", "value", "90 % interval", "unit", "where from"),
                      "The linear record of " + text(record, "/name")) if rows else ""


def export(folder, page):
    if folder.program != "drape_export":
        return ""
    s = folder.summary
    rows = [(html.header(text(target, "/target")),
             html.number_cell(target, "/round_trip/dc_change", 100, "%+.1f"),
             html.number_cell(target, "/round_trip/nodes_change", 1, "%+.1f"),
             (text(target, "/file"), ""), (text(target, "/status"), ""),
             ("; ".join(texts(target, "/lost")) or "nothing", ""))
            for target in items(s, "/targets")]
    targets = html.table(rows, ("target", "change of drape coefficient [points]", "change of nodes",
                                "file", "status", "what is lost"),
                         "Targets, and how the fabric drapes here with what is left of it")
    return html.join([targets if rows else "", linear_record(find(s, "/record")),
                      *(html.paragraph("Samples of the posterior: " + file)
                        for file in texts(s, "/posterior_files"))])


def pictures(folder, page):
    """Charts, and the pictures that no other part shows; of a chart the drawing without pixels."""
    html_parts = []
    files = folder.files(".svg", ".png")
    for file in files:
        shown = (folder.is_fit and file.startswith("fit_") or file == "mean_image.png" or
                 folder.program == "drape_photo" and file == "overlay.png")
        if not shown and not (file.endswith(".png") and file[:-4] + ".svg" in files):
            html_parts.append(page.picture(folder.at(file), file, file))
    return html.join(html_parts)


def garments(folder, page):
    """The runs of drape_garment, which are in the summary alone."""
    runs = items(folder.summary, "/runs") if folder.program == "drape_garment" else []
    return page.fit(f"{folder.name}: runs", html.objects_table(runs)) if runs else ""


def tables(folder, page):
    parts = []
    for file in folder.files(".md", ".csv"):
        try:
            content = read_text(folder.at(file))
            markup = (html.markdown(content) if file.endswith(".md") else
                      html.details("Table " + file, html.csv_table(content)))
            parts.append(page.fit(f"{folder.name}/{file}", markup))
        except (InputError, html.csv.Error) as error:
            parts.append(html.paragraph(str(error), "missing"))
    return html.join(parts)


def studies(folder, page):
    return html.join(part(folder, page) for part in (pictures, garments, tables))


def shell_line(words):
    """Words as a shell takes them: those that it would change are quoted."""
    def escape(match):
        if match[0] == "'":
            return r"'\''"
        return "'$'%s''" % "".join(f"\\x{byte:02x}" for byte in os.fsencode(match[0]))
    return " ".join(word if re.fullmatch(r"[A-Za-z0-9\-_=+,./:@%]+", word) else "'" + re.sub(
        "['\x00-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\udc80-\udcff]", escape, word) + "'"
                    for word in words)


def command_text(command):
    return shell_line(map(value_text, command)) if isinstance(command, list) else value_text(command)


def joined(value, keys):
    return ", ".join(before + value_text(find(value, "/" + key)) for key, before in keys
                     if find(value, "/" + key) is not None)


def run_rows(folder, run):
    options = find(run, "/options")
    options = options if isinstance(options, dict) else {}
    build = [("drapefit", "drapefit "), ("commit", "commit "), ("compiler", "compiler "),
             ("build_type", ""), ("instructions", ""), ("ceres", "Ceres "), ("cholmod", "CHOLMOD "),
             ("eigen", "Eigen "), ("glibc", "glibc ")]
    rows = [("command", command_text(run["command"]) if "command" in run else ""),
            ("repeated by", shell_line([folder.program, "--config=" + folder.at(folder.file),
                                        "--out=NEW"]) if options else ""),
            ("in the folder", text(run, "/working_directory")),
            ("started", text(run, "/started")),
            ("took [s]", value_text(run["seconds"]) if "seconds" in run else ""),
            ("machine", joined(run, [("host", ""), ("processor", ""), ("cores", "cores "),
                                     ("threads", "threads "), ("gpu", "")])),
            ("build", joined(find(run, "/build"), build)),
            ("seeds", ", ".join(f"{key} {value_text(options[key])}" for key in sorted(options)
                                if re.fullmatch("seed|.*_seed|.*seeds", key)))]
    return [(html.header(name), (value, "")) for name, value in rows if value]


def provenance(folder, page):
    s = folder.summary
    run = find(s, "/provenance")
    parts = []
    if isinstance(run, dict):
        files = items(run, "/inputs") + items(run, "/configs")
        rows = [((text(file, "/path"), ""),
                 html.numeric("" if number(file, "/bytes") is None else "%.0f" % file["bytes"]),
                 (text(file, "/sha256"), "")) for file in files]
        parts += [html.table(run_rows(folder, run)),
                  html.details(f"Files that the run read ({len(rows)})", html.table(
                      rows[:html.MOST_ROWS], ("file", "bytes", "SHA-256")) +
                      html.more_rows(rows)) if rows else "",
                  html.details("All options of the run", html.flat_table(run["options"]))
                  if "options" in run else ""]
    plain = {key: value for key, value in s.items()
             if value is not None and not isinstance(value, (dict, list))}
    parts.append(html.details("Settings and results of the run",
                              html.flat_table({"program": folder.program, "folder": folder.path} | plain)))
    parts += [html.details(key, html.flat_table(s[key]))
              for key in ("seconds", "meshes", "simpler_models", "initial_guess")
              if isinstance(s.get(key), (dict, list))]
    return html.join(page.fit(folder.name + ": where it is from", part) for part in parts if part)
