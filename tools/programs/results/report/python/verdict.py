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
    "drape_photo": "A photograph of a drape.",
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


def fit_numbers(s):
    numbers = []
    rms, scale = number(s, "/mean/profile_rms_px"), number(s, "/images/0/camera/px_per_m")
    if rms is not None and scale:
        numbers.append(("outline error, rms", "%.2f mm" % (1e3 * rms / scale)))
    numbers += pair(s, "drape coefficient, image and fit", "/mean/dc_image", "/mean/dc_fit", 100,
                    "%.1f %%")
    images = items(s, "/images")
    if len(images) == 1 and find(images[0], "/photograph"):
        numbers.append(("drape coefficient, photograph",
                        coefficient_text(find(images[0], "/photograph")) + " %"))
    numbers += pair(s, "nodes, image and fit", "/mean/folds_image", "/mean/folds_fit", 1, "%.3g")
    bend, factor = number(s, "/verdict/bend_n_m/value"), number(s, "/verdict/bend_n_m/factor_90")
    if bend is not None and factor and find(s, "/verdict/bend_n_m/determined") is True:
        micro = 1e6 * bend
        numbers.append(("bending rigidity, 90 % interval",
                        "%.3g (%.3g … %.3g) µN·m" % (micro, micro / factor, micro * factor)))
    directions = number(s, "/spectrum/determined_directions")
    count = number(s, "/parameters/count")
    if directions is not None and count is not None:
        numbers.append(("directions that the data determine", "%.0f of %.0f" % (directions, count)))
    return numbers


def fit_verdict(s):
    """Look, grade and sentence."""
    grade = text(s, "/verdict/grade")
    if grade == "good":
        first = ("Outline, area and nodes are as in the image, at rest and stable. "
                 if find(s, "/images") is not None else
                 "The fabric is as the laboratory measured it. ")
        return "good", "Good", first + ("Trust the numbers that are marked as measured, within their "
                                        "intervals.")
    if grade == "usable":
        return "usable", "Usable", "Read the warnings before you use these numbers."
    if not grade:
        return "bad", "No verdict", "The fit has no verdict: it is not complete."
    return "bad", "Do not use", "These results are not fit for use, for the reasons below."


def of_fit(folder):
    look, grade, sentence = fit_verdict(folder.summary)
    warnings = texts(folder.summary, "/verdict/reasons") + changed_images(folder) + notes(folder)
    return html.BLOCKS.verdict(look, folder.name, grade, warnings, sentence, "",
                               fit_numbers(folder.summary))


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
        elif pointer == "/dc" and folder.program == "drape_photo":
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
    return html.BLOCKS.verdict("", folder.name, "", warnings,
                               PURPOSES.get(folder.program, folder.program), conclusions(folder),
                               other_numbers(folder))


def verdicts(folders):
    parts = html.join((of_fit if folder.is_fit else of_other)(folder) for folder in folders)
    if len(folders) > 1:
        parts = html.markupsafe.Markup('<div class="side">%s</div>') % parts
    return html.BLOCKS.warnings(other_sizes(folders)) + parts


def plain(value, digits):
    """A number without an exponent up to 999,999: "766", "1346", not "1.35e+03"."""
    whole = 10 ** digits <= abs(value) < 1e6
    return "%.6g" % round(value) if whole else "%.*g" % (digits, value)


def reading(row, pointer, digits):
    """"> 20" of a number that is not stored because its instrument reads up to 20."""
    value, most = number(row, pointer), number(row, "/reads_up_to")
    if value is not None:
        return plain(value, digits)
    return "none" if most is None else "> " + plain(most, 3)


def sheet_row(row):
    ends = [number(row, "/low"), number(row, "/high"), number(row, "/reads_up_to")]
    known = ends[0] is not None and (ends[1] is not None or ends[2] is not None)
    source, kind = html.origin(text(row, "/source"))
    return (html.header(text(row, "/name")), html.numeric(reading(row, "/value", 4)),
            html.numeric(f"{reading(row, '/low', 3)} … {reading(row, '/high', 3)}" if known else ""),
            (text(row, "/unit"), ""),
            ("; ".join(filter(None, [source, text(row, "/note")])), kind),
            (text(row, "/standard"), ""))


def laboratory_sheet(sheet):
    """One sheet of the block "laboratory" of a summary, of a material or of a drape."""
    rows = [sheet_row(row) for row in items(sheet, "/rows")]
    head = ("quantity", "value", "90 % interval", "unit", "where from", "standard")
    return html.table(rows, head, text(sheet, "/title")) if rows else ""


def in_words(s):
    bend = find(s, "/verdict/bend_n_m/determined")
    stretch = find(s, "/verdict/stretch_n_per_m/determined")
    length = number(s, "/bending/bending_length_m")
    if bend is None or stretch is None or length is None:
        return ""
    hand = "soft" if length < 0.012 else "of medium stiffness" if length < 0.02 else "stiff"
    first = (f"The cloth is {hand}: a strip of it bends under its own weight with a bending length of "
             "%.1f cm. " % (100 * length) if bend is True else
             "The data do not determine how stiff the cloth bends. ")
    return html.paragraph(first + ("Stretching is measured as well." if stretch is True else
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
    return in_words(s) + html.join(page.fit(folder.name + ": material", part)
                                   for part in [table, *others, strips(s)] if part)
