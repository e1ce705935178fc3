# SPDX-License-Identifier: Apache-2.0
"""The verdict on the results, with the warnings first, and the material of the cloth."""

import os

import page as html
from results import (InputError, coefficient_text, find, items, number, number_text, read_text, text,
                     texts, value_text)

PURPOSES = {
    "drape_predict": "A prediction: the distribution of the drapes of a fabric.",
    "drape_simulate": "One drape.",
    "drape_equilibria": "The stable drapes of one fabric.",
    "drape_compare": "A comparison of material models on held-out drapes.",
    "drape_bench": "Cost and accuracy of drapes, derivatives or fits.",
    "drape_speed": "Time of a step, forward and backward.",
    "drape_stability": "Where solvers of a drape fail.",
    "drape_gradients": "Where gradients of a drape fail.",
    "drape_space": "Distances between fabrics, and their population.",
    "drape_compare_optimisers": "Optimisers under equal budgets.",
    "drape_garment": "A moving body in a garment.",
    "drape_photo": "Photographs of drapes.",
    "drape_export": "A fabric for other programs.",
    "drape_metrics": "Measured drapes.",
}


def sizes_text(discs):
    return "%g cm on %g cm" % tuple(100 * size for size in discs)


def other_sizes(folders):
    """Drape coefficients, nodes and outlines of specimens of different sizes cannot be compared."""
    sized = [folder for folder in folders if folder.discs()]
    return [f"The drapes of {folder.name} are of specimens of {sizes_text(folder.discs())}, those of "
            f"{sized[0].name} of {sizes_text(sized[0].discs())}: their drape coefficients, nodes and "
            "outlines cannot be compared."
            for folder in sized if folder.discs() != sized[0].discs()]


def notes(folder):
    return texts(folder.summary, "/notes") + texts(folder.summary, "/warnings")


def changed_images(fit):
    changed = []
    for image in items(fit.summary, "/images"):
        try:
            if fit.changed(text(image, "/file")):
                changed.append(text(image, "/file") + " is not the file that was fitted: it has "
                               "changed since.")
        except InputError:  # the part with the images says why
            pass
    return changed


def pair(summary, name, of_image, of_fit, factor, form):
    seen, fitted = number(summary, of_image), number(summary, of_fit)
    if seen is None or fitted is None:
        return []
    return [(name, f"{form % (factor * seen)} and {form % (factor * fitted)}")]


def rows_of_material(s):
    return {text(row, "/key"): row for row in items(s, "/laboratory/material/rows")}


def is_measured(row):
    return text(row, "/source").startswith("measured")


def measured_bending(s):
    """The measured rigidities and bending lengths."""
    return [row for key, row in rows_of_material(s).items()
            if key.startswith("bending_") and key != "bending_ratio" and is_measured(row)]


def row_text(row):
    """The value, the interval and the origin of a row, in the words of the fit."""
    interval = text(row, "/interval")
    return (f"{text(row, '/text')} {text(row, '/unit')}" + (f" ({interval})" if interval else "") +
            f", {text(row, '/source')}")


def fit_numbers(s):
    numbers = pair(s, "drape coefficient, image and fit", "/mean/dc_image", "/mean/dc_fit", 100,
                   "%.1f %%")
    images = items(s, "/images")
    if len(images) == 1 and find(images[0], "/photograph"):
        numbers.append(("drape coefficient, photograph",
                        coefficient_text(find(images[0], "/photograph")) + " %"))
    numbers += pair(s, "nodes, image and fit", "/mean/folds_image", "/mean/folds_fit", 1, "%.3g")
    rms, scale = number(s, "/mean/profile_rms_px"), number(s, "/images/0/camera/px_per_m")
    if rms is not None and scale:
        numbers.append(("outline error, rms", "%.2f mm" % (1e3 * rms / scale)))
    bending = measured_bending(s)
    if bending:
        numbers.append((text(bending[0], "/name"), row_text(bending[0])))
    directions = number(s, "/spectrum/determined_directions")
    count = number(s, "/parameters/count")
    if directions is not None and count is not None:
        numbers.append(("directions that the data determine", "%.0f of %.0f" % (directions, count)))
    return numbers


LAMPS = {"measurement": "Measurement", "shape": "Shape", "bending": "Bending"}
LOOKS = {"good": "good", "usable": "usable", "do not use": "bad"}


def of_fit(folder):
    s = folder.summary
    lamps = [(LOOKS.get(text(s, f"/verdict/lamps/{lamp}/grade"), "bad"),
              f"{name}: " + (text(s, f"/verdict/lamps/{lamp}/grade") or "no verdict"),
              texts(s, f"/verdict/lamps/{lamp}/reasons")) for lamp, name in LAMPS.items()]
    return html.BLOCKS.lamps(folder.name, changed_images(folder) + notes(folder), fit_numbers(s), lamps)


def best_method(s):
    """The first of the methods that solve most problems: "lm, 75 %"."""
    shares = [(number(method, "/solved_at_0.1"), text(method, "/name"))
              for method in items(s, "/methods") if number(method, "/solved_at_0.1") is not None]
    if not shares:
        return []
    share, name = max(shares, key=lambda each: each[0])
    return [("solves most problems to within 10 %", name + ", %.0f %%" % (100 * share))]


# Pointer, name, factor and unit of the numbers that a summary leads with.
HEADLINES = [("/draws", "drapes", 1, ""), ("/at_rest", "drapes at rest", 1, ""),
             ("/features/dc", "drape coefficient", 100, " %"), ("/features/folds", "nodes", 1, ""),
             ("/spread/dc", "drape coefficient", 100, " %"), ("/spread/folds", "nodes", 1, ""),
             ("/dc", "drape coefficient", 100, " %"), ("/folds", "nodes", 1, ""),
             ("/stability/lowest_frequency_hz", "lowest vibration", 1, " Hz"),
             ("/settings/budget_rollouts", "rollouts for each method and problem", 1, "")]


def other_numbers(folder):
    s = folder.summary
    numbers = []
    for pointer, name, factor, unit in HEADLINES:
        found, value = find(s, pointer), number(s, pointer)
        if isinstance(found, dict):
            mean, deviation = number(found, "/mean"), number(found, "/sd")
            known = mean is not None and deviation is not None
            numbers.append((name, "%.3g ± %.2g" % (factor * mean, factor * deviation) + unit
                            if known else "none"))
        elif value is not None and pointer == "/dc" and folder.program == "drape_photo":
            numbers.append((name, coefficient_text(s) + " %"))
        elif value is not None and (pointer, folder.program) != ("/draws", "drape_garment"):
            numbers.append((name, "%.4g" % (factor * value) + unit))
    numbers += best_method(s)
    if folder.program == "drape_bench":
        numbers.append(("runs", str(len(items(s, "/cells")))))
    return numbers


def conclusions(folder):
    """The conclusions of a comparison, in its own words."""
    file = folder.at("comparison.md")
    if folder.program != "drape_compare" or not os.path.exists(file):
        return ""
    return html.join(html.markdown(line) for line in read_text(file).splitlines()
                     if line.startswith("**"))


def of_other(folder):
    s = folder.summary
    warnings = notes(folder)
    if (text(s, "/outcome") or text(s, "/status")) == "cancelled":
        warnings.insert(0, "The run was cancelled.")
    failures = find(s, "/failures")
    if isinstance(failures, dict):
        warnings += [f"{value_text(failures[reason])} drapes: {reason}" for reason in sorted(failures)]
    return html.BLOCKS.verdict(folder.name, warnings,
                               PURPOSES.get(folder.program, folder.program), conclusions(folder),
                               other_numbers(folder))


def verdicts(folders):
    parts = html.join((of_fit if folder.is_fit else of_other)(folder) for folder in folders)
    if len(folders) > 1:
        parts = html.markupsafe.Markup('<div class="side">%s</div>') % parts
    return html.BLOCKS.warnings(other_sizes(folders)) + parts


def unit_look(row, twins):
    """Which of the two systems of units shows a row that both have."""
    key = text(row, "/key")
    return "kes" if key.startswith("kes_b_") else "si" if twins and key.startswith("bending_") and (
        key.endswith("_un_m")) and "in_drape" not in key else ""


def sheet_row(row, twins):
    source, kind = html.origin(text(row, "/source"))
    return (html.header(text(row, "/name")), html.numeric(text(row, "/text")),
            html.numeric(text(row, "/interval")), (text(row, "/unit"), unit_look(row, twins)),
            ("; ".join(filter(None, [source, text(row, "/note")])), kind),
            (text(row, "/standard"), ""))


def laboratory_sheet(sheet):
    """One sheet of the block "laboratory" of a summary, of a material or of a drape."""
    found = items(sheet, "/rows")
    twins = any(text(row, "/key").startswith("kes_b_") for row in found)
    head = ("quantity", "value", "90 % interval", "unit", "where from", "standard")
    prior = [row for row in found if text(row, "/source") == "from the prior"]
    shown = [sheet_row(row, twins) for row in found if row not in prior]
    folded = html.details(f"From the prior, not measured ({len(prior)})", html.table(
        [sheet_row(row, twins) for row in prior], head)) if prior else ""
    sheet_table = html.table(shown, head, text(sheet, "/title")) if shown else ""
    return html.BLOCKS.sheet(sheet_table + folded, text(sheet, "/title"), twins) if found else ""


def in_words(s):
    rows = rows_of_material(s)
    bend = measured_bending(s)
    stretch = is_measured(rows.get("stretch_in_drape_n_per_m"))
    length = number(s, "/bending/bending_length_m")
    if not rows or length is None:
        return ""
    hand = "soft" if length < 0.012 else "of medium stiffness" if length < 0.02 else "stiff"
    first = (f"The cloth is {hand}: a strip of it bends under its own weight with a bending length of "
             "%.1f cm. " % (100 * length) if bend else
             "The data do not determine how stiff the cloth bends. ")
    return html.paragraph(first + ("Stretching is measured as well." if stretch else
                                   "Stretching and shear are not determined by a drape: those "
                                   "numbers come from the prior."))


def strips(s):
    """A table of the readings of each laboratory measurement."""
    tables = html.join(
        html.objects_table(items(strip, "/points"),
                           f"{text(strip, '/name')}: {text(strip, '/test')}, "
                           f"{number_text(strip, '/direction', 1, '%g')} degrees from the weft")
        for strip in items(s, "/lab_measurements"))
    return html.details("Laboratory measurements, and what the fitted fabric gives",
                        tables) if tables else ""


def material(folder, page):
    s = folder.summary
    sheets = find(s, "/laboratory")
    sheets = sheets if isinstance(sheets, dict) else {}
    table = laboratory_sheet(sheets.get("material"))
    if not folder.is_fit or not table:
        return ""
    others = [laboratory_sheet(sheets[name]) for name in sorted(sheets) if name != "material"]
    if len(others) > 3:
        others = [html.details(f"Sheets of each image, and other forms ({len(others)})",
                               html.join(others))]
    return in_words(s) + html.join(page.fit(folder.name + ": material", part)
                                   for part in [table, *others, strips(s)] if part)
