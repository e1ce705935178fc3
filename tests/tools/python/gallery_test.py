# SPDX-License-Identifier: Apache-2.0
"""Runs the code cells of a notebook of the gallery in order. Skipped where its packages are missing.
usage: gallery_test.py <first letters of its name>"""
import json
import os
import sys
import tempfile

from python_fixture import SOURCE

OPTIONAL = {"matplotlib", "torch", "xarray"}


def check_form(notebook):
    """It is a notebook of version 4 with a title and without outputs."""
    assert notebook["nbformat"] == 4
    title, *_ = notebook["cells"]
    assert title["cell_type"] == "markdown" and title["source"][0].startswith("# "), title
    assert not any(cell.get("outputs") for cell in notebook["cells"])
    try:
        import nbformat
    except ImportError:
        return
    nbformat.validate(notebook)


def main():
    path, = (SOURCE / "tools/python/gallery").glob(f"{sys.argv[1]}*.ipynb")
    notebook = json.loads(path.read_text(encoding="utf-8"))
    check_form(notebook)
    os.environ["MPLBACKEND"] = "Agg"
    names = {"__name__": "__main__"}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            for number, cell in enumerate(notebook["cells"], 1):
                if cell["cell_type"] == "code":
                    exec(compile("".join(cell["source"]), f"{path.name}, cell {number}", "exec"), names)
        except ImportError as error:
            if error.name not in OPTIONAL:
                raise
            print(f"{path.name} needs a package: {error}")
            sys.exit(77)
        finally:
            os.chdir("/")


if __name__ == "__main__":
    main()
