# SPDX-License-Identifier: Apache-2.0
"""The tables of drape_bench on made-up runs."""

import contextlib
import csv
import io
import json
import math
import pathlib
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[5] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import bench  # noqa: E402
import study  # noqa: E402


def cell(seconds, radius_mm, status="ok", **axes):
    axes = {"material": "a", "law": "smooth", "model": "homogeneous", "mesh": "disc:300",
            "solve": "hybrid", "time_step": 0.1, "relax_time": 10.0, "tolerance": 1e-9,
            "mode": "adjoint", "backend": "cpu", "threads": 1} | axes
    return {"name": "", "input": axes,
            "result": {"status": status, "seconds": seconds, "cpu_seconds": seconds / 2,
                       "radius_mm": radius_mm, "vertices": int(axes["mesh"][5:]), "peak_mb": 2.0,
                       "force_residual": 1e-10 * radius_mm, "drift_mm": 1e-3 * radius_mm}}


def made_up(cells, **members):
    """The study of a folder that does not exist."""
    made = study.Study.__new__(study.Study)
    made.json = {"settings": {"work": "forward", "reference": "disc:1,disc:2"}, "clock": "wall",
                 "start": "waves.json", "error_margin": 1.5, "published": None,
                 "cells": cells} | members
    return made


def two_fabrics():
    """The finer mesh is 16 times as slow, and its coarse step leaves the branch of one fabric. Two
    seconds for 1 mm would beat every other row, were it at rest with both fabrics."""
    cells = []
    for material, worse in (("a", 1), ("b", 2)):
        def add(mesh, solve, time_step, error, seconds, status="ok"):
            cells.append(cell(seconds, error * worse, status if worse > 1 else "ok",
                              material=material, mesh=mesh, solve=solve, time_step=time_step))
        add("disc:300", "hybrid", 0.1, 8, 1)
        add("disc:1200", "hybrid", 0.1, 1, 16)
        add("disc:1200", "hybrid", 0.2, 1, 8, "other branch")
        add("disc:600", "dynamic", 0.1, 3, 4)
        add("disc:4800", "static", 0.1, 0.1, 1)
        add("disc:1200", "dynamic", 0.4, 1, 2, "not at rest")
    return cells


class ParetoTest(unittest.TestCase):
    def test_holds_what_no_point_beats_fastest_first(self):
        nan = math.nan
        points = [(3, 1), (1, 5), (2, 5), (2, 2), (4, 1), (2, 2), (nan, 0), (0, nan)]
        self.assertEqual(bench.pareto(points, lambda point: point), [(1, 5), (2, 2), (3, 1)])
        points = [(1, 0.5), (2, 0.5 * (1 - 1e-9)), (3, 0.4999)]
        self.assertEqual(bench.pareto(points, lambda point: point), [points[0], points[2]])
        self.assertEqual(bench.pareto([], None), [])


class RunsTest(unittest.TestCase):
    def test_a_method_is_what_the_axes_vary(self):
        def method(*cells):
            made = bench.Bench(made_up(list(cells)))
            return made.method(made.runs[-1])
        self.assertEqual(method(cell(1, 1)), "hybrid")
        self.assertEqual(method(cell(1, 1, backend="cuda"), cell(1, 1)), "cpu")
        self.assertEqual(method(cell(1, 1), cell(1, 1, backend="cuda", solve="static")),
                         "static cuda")

    def test_labels_have_what_a_run_has_of_the_varied_axes(self):
        made = bench.Bench(made_up([cell(1, 1, model="bdp", draws=8), cell(1, 1, model="bdp", draws=16),
                                    cell(1, 1, time_step=0.2)]))
        self.assertEqual([made.label(run) for run in made.runs],
                         ["bdp draws=8 time_step=0.1", "bdp draws=16 time_step=0.1",
                          "homogeneous time_step=0.2"])

    def test_growth_has_the_exponents_of_runs_that_differ_in_the_mesh(self):
        made = bench.Bench(made_up([cell(2, 1), cell(2 * 16, 1, mesh="disc:1200"),
                                    cell(1, 1, solve="static")]))
        (name, runs), = made.growth().items()
        self.assertEqual(name, "hybrid")
        self.assertAlmostEqual(bench.exponent(runs, bench.time_of), 2)
        self.assertAlmostEqual(bench.exponent(runs, bench.megabytes_of), 0)

    def test_what_is_not_at_rest_is_on_no_front(self):
        made = bench.Bench(made_up(two_fabrics()))
        self.assertTrue(all(run.ok for run in made.front("radius_mm")))
        self.assertTrue(made.front("radius_mm"))


class AccuracyTest(unittest.TestCase):
    def table(self, cells, **members):
        return bench.accuracy_table(bench.Bench(made_up(cells, **members)), 1.5)

    def test_promises_the_worst_fabric_times_the_margin(self):
        table = self.table(two_fabrics())
        self.assertEqual([row["mesh"] for row in table["rows"]], ["disc:300", "disc:600", "disc:1200"])
        self.assertEqual([row["error_mm"] for row in table["rows"]], [24, 9, 3])
        self.assertEqual([row["cost"] for row in table["rows"]], [1 / 16, 1 / 4, 1])
        self.assertEqual((table["fast_mm"], table["exact_mm"]), (24, 3))
        self.assertAlmostEqual(table["balanced_mm"], math.sqrt(72))
        self.assertAlmostEqual(table["rows"][0]["residual"], 16e-10)  # of the worse fabric
        self.assertAlmostEqual(table["rows"][0]["drift_mm"], 16e-3)
        self.assertEqual(table["rows"][0]["steps"], 100)
        self.assertEqual(table["made_on"], "forward start=waves.json reference=disc:1+disc:2")

    def test_adds_the_error_of_the_reference(self):
        cells = two_fabrics()
        cells[0]["result"]["reference_errors"] = {"radius_mm": 0.5}
        self.assertEqual(self.table(cells)["exact_mm"], 1.5 * (2 + 0.5))

    def test_takes_the_clock_that_counts(self):
        cells = two_fabrics()
        for each in cells:
            each["result"]["cpu_seconds"] = 1.0
        self.assertEqual([row["mesh"] for row in self.table(cells, clock="cpu")["rows"]],
                         ["disc:1200", "disc:600"])

    def test_a_setting_that_is_not_at_rest_has_no_row(self):
        cells = two_fabrics()
        self.assertFalse([row for row in self.table(cells)["rows"] if row["time_step"] == 0.4])
        for each in cells:
            if each["input"]["solve"] == "hybrid":
                each["result"]["status"] = "not at rest"
        self.assertIsNone(self.table(cells))

    def test_twice_the_time_for_nothing_is_no_row(self):
        more = [cell(32, 0.999 * worse, material=material, mesh="disc:1200", time_step=0.05)
                for material, worse in (("a", 1), ("b", 2))]
        self.assertEqual(len(self.table(two_fabrics() + more)["rows"]), 3)


class CodesTest(unittest.TestCase):
    def test_a_published_program_has_the_error_of_its_mesh(self):
        cells = [cell(0.05, 2.0), cell(0.06, 8.0, law="reference"),
                 cell(0.4, 3.3, law="reference", mesh="disc:1200")]
        published = {"vertices": [297, 1205, 2699],
                     "rows": [{"name": "other", "machine": "a GPU", "forward_s": [0.01, 0.03, 0.1]},
                              {"name": "third", "machine": "a CPU", "backward_s": [1, 2, 3]}]}
        codes = bench.compare_codes(bench.Bench(made_up(cells)), published)
        self.assertEqual(codes, {"drapefit, 1 thread": [(300, 0.05, 2.0)],
                                 # no run is like the third mesh
                                 "other, a GPU": [(297, 1.0, 8.0), (1205, 3.0, 3.3)]})
        self.assertEqual(bench.compare_codes(bench.Bench(made_up(cells[:1])), published), {})


class FilesTest(unittest.TestCase):
    def draw(self, cells, **members):
        """The files of a study and what the script prints."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        made = made_up(cells, **members)
        made.folder = pathlib.Path(folder.name)
        with contextlib.redirect_stdout(io.StringIO()) as out:
            bench.draw(made)
        return made.folder, out.getvalue()

    def test_tables_name_all_runs(self):
        folder, text = self.draw(two_fabrics())
        self.assertIn("12 runs, not on the front: 1 not at rest; 1 other branch\n", text)
        rows = list(csv.reader((folder / "runs.csv").read_text(encoding="utf-8").splitlines()))
        self.assertEqual(rows[0], ["# forward start=waves.json reference=disc:1+disc:2"])
        self.assertEqual(rows[1][:5], ["work", "material", "law", "model", "draws"])
        self.assertEqual(len(rows), 2 + 12)
        self.assertEqual(rows[2][rows[1].index("seconds")], "1")
        self.assertEqual(rows[2][rows[1].index("draws")], "")
        self.assertEqual(json.loads((folder / "accuracy.json").read_text())["exact_mm"], 3)
        self.assertIn("# Exponents of growth", (folder / "report.md").read_text(encoding="utf-8"))

    def test_a_fabric_without_a_reference_is_named(self):
        none = {**cell(0, 0), "result": {"status": "no reference", "peak_mb": 0,
                                         "failure": "no reference of lead"}}
        folder, text = self.draw([none, none])
        self.assertIn("2 runs, not on the front: 2 no reference\nno reference of lead\n"
                      "no accuracy.json: ", text)
        self.assertFalse((folder / "accuracy.json").exists())

    @unittest.skipIf(study.pyplot is None, "python3-matplotlib is not installed")
    def test_names_in_charts_are_text(self):
        cells = two_fabrics()
        for each in cells:
            each["input"]["material"] += "$\\frac{a}$ <b>_^"
        folder, _ = self.draw(cells)
        self.assertIn("$\\frac{a}$ &lt;b&gt;_^", (folder / "front_radius_mm.svg").read_text())
        for chart in ("front_radius_mm.png", "growth.png", "growth.svg"):
            self.assertGreater((folder / chart).stat().st_size, 1000)


if __name__ == "__main__":
    unittest.main()
