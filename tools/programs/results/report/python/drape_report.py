# SPDX-License-Identifier: Apache-2.0
"""Makes one page of finished results.

usage: drape_report.py OUT MAX_MB FOLDER...
"""

import contextlib
import os
import secrets
import signal
import sys
import warnings

EXIT_BAD_INPUT, EXIT_CANCELLED = 2, 130
SIGNALS = [signal.SIGINT, signal.SIGTERM]
unfinished = []  # files that a signal removes


def end(*_):
    for path in unfinished:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(path)
    os._exit(EXIT_CANCELLED)


for each in SIGNALS:
    signal.signal(each, end)
signal.pthread_sigmask(signal.SIG_UNBLOCK, SIGNALS)  # drape_report has blocked them


def refuse(message):
    line = " ".join(message.encode("utf-8", "replace").decode().split())
    print(f"drape_report: error: {line}", file=sys.stderr)
    sys.exit(EXIT_BAD_INPUT)


try:
    import certificate
    import charts
    import drapes
    import measured
    import page as html
    import results
    import verdict
except ImportError as missing:
    refuse(f"{missing} (Debian: python3-jinja2, python3-numpy, python3-matplotlib)")

TEMPLATE = os.path.join(os.path.dirname(__file__), "..", "page", "template.html")
# Sections: id, heading, markup of a folder, and the explanation above the markup of all folders.
SECTIONS = [("measurement", "Measurement", measured.measurement),
            ("images", "Image and fit", drapes.images),
            ("material", "Material", verdict.material),
            ("export", "For other programs", measured.export),
            ("outlines", "Drapes from above", drapes.outlines, drapes.how_to_read),
            ("drape", "Drape in three dimensions", drapes.drapes, drapes.how_to_turn),
            ("fields", "Fields over the cloth", charts.cloth_fields),
            ("posterior", "Posterior", charts.posterior),
            ("prediction", "Prediction", charts.prediction),
            ("spectrum", "What the data determine", charts.spectrum),
            ("studies", "Charts and tables", measured.studies),
            ("provenance", "Where these results are from", measured.provenance)]


def make_page(folders, max_mb):
    with open(TEMPLATE, encoding="utf-8") as file:
        template = file.read()
    frame = 40_000  # bytes of the head, of captions and of the lines on what is left out
    page = html.Page(folders, max(0, int(1e6 * max_mb) - len(template.encode()) - frame))
    names = certificate.add_first_page(folders, page)
    page.add("verdict", "Verdict", verdict.verdicts(folders))
    for part, heading, of_folder, *explain in SECTIONS:
        markup = page.side_by_side(of_folder)
        page.add(part, heading, html.join([*(above(markup) for above in explain), markup]))
    title = "drapefit report: " + ", ".join(names or (folder.name for folder in folders))
    body = html.ENVIRONMENT.get_template("body.html").render(
        title=title, sections=page.sections, left_out=page.left_out, max_mb=max_mb)
    # The inserted text is not searched again.
    head, template = template.split("%%TITLE%%")
    middle, template = template.split("%%BODY%%")
    tail, end = template.split("%%DATA%%")
    return "".join([head, html.markupsafe.escape(html.printable(title)), middle, body, tail,
                    html.script_json({"drapes": page.drapes, "bodies": page.bodies}), end])


def read_folders(paths):
    folders = [results.read_folder(path) for path in paths]
    names = [folder.name for folder in folders]
    for folder in folders:
        if names.count(folder.name) > 1:
            folder.name = folder.path
    return folders


def write_atomically(path, content):
    """An earlier page stays until the new one is complete."""
    new = os.path.join(os.path.dirname(path), f".drapefit_{secrets.token_hex(8)}.tmp")
    unfinished.append(new)
    try:
        with open(new, "xb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(new, path)
    except OSError as error:
        refuse(f"{path}: cannot be written: {error.strerror}")
    finally:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(new)


def main(out, max_mb, *paths):
    try:
        page = make_page(read_folders(paths), float(max_mb)).encode("utf-8", "replace")
    except results.InputError as error:
        refuse(str(error))
    write_atomically(out, page)
    print("see %s (%.2f MB)" % (out, 1e-6 * len(page)))


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # of charts of damaged numbers
    main(*sys.argv[1:])
