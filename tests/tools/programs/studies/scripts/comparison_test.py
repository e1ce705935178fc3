# SPDX-License-Identifier: Apache-2.0
"""Runs of a comparison are summed up, chosen from and written."""

import contextlib
import io
import json
import math
import os
import pathlib
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[5] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import comparison as compare  # noqa: E402
import study  # noqa: E402


def make_run(fabric, model, seed, energy):
    return {"fabric": fabric, "model": model, "seed": seed,
            "numbers": {"feature_energy": energy, "outline_energy_m": 0.004},
            "captures": [{"fabric": fabric, "sample": seed, "capture": capture,
                          "feature_energy": energy + 0.1 * (capture % 2)}
                         for capture in range(1, 5)]}


def make_comparison():
    runs = []
    for fabric in (2, 5):
        for seed in (1, 2):
            runs.append(make_run(fabric, "homogeneous", seed, 2.0 + seed if fabric == 2 else 1.0))
            runs.append(make_run(fabric, "bayes", seed, 1.0 if fabric == 2 else 1.5))
            runs[-1]["posterior"] = {"stretch_n_per_m": [100.0 * seed, 10], "bend_n_m": [1e-6, 1e-7]}
            runs.append(make_run(fabric, "circle", seed, 9.0) | {"captures": []})
    return {"models": [{"name": "homogeneous", "meaning": "one table"},
                       {"name": "bayes", "meaning": "a posterior"}], "runs": runs,
            "provenance": {"program": "drape_compare", "build": {"drapefit": "0.1.0", "commit": "abc"}}}


class ChooseSimplest(unittest.TestCase):
    def choose(self, *models):
        choice = compare.choose_simplest(list(models))
        return choice["best"], choice["chosen"], choice["models"]

    def test_a_clearly_better_model_is_chosen_though_it_is_not_simple(self):
        best, chosen, models = self.choose(("homogeneous", [3, 4, 5, 4]), ("bayes", [1, 2, 3, 1.9]))
        self.assertEqual((best, chosen), ("bayes", "bayes"))
        self.assertEqual(models[0]["mean_score"], 4)
        self.assertAlmostEqual(models[0]["difference_from_best"], 2.025, 12)

    def test_within_one_standard_error_the_simpler_is_chosen(self):
        """Differences 1, -1, 2, -1: mean .25, deviation 1.5, standard error .75."""
        best, chosen, models = self.choose(("homogeneous", [2, 1, 4, 3]), ("bayes", [1, 2, 2, 4]))
        self.assertEqual((best, chosen), ("bayes", "homogeneous"))
        self.assertAlmostEqual(models[0]["difference_from_best"], 0.25, 12)
        self.assertAlmostEqual(models[0]["standard_error"], 0.75, 12)

    def test_the_error_is_that_of_pairs(self):
        """The scores scatter by tens, their differences do not."""
        _, chosen, models = self.choose(("homogeneous", [10.2, 20.3, 30.2, 40.3]),
                                        ("bdp", [10, 20, 30, 40]))
        self.assertEqual(chosen, "bdp")
        self.assertLess(models[0]["standard_error"], 0.05)

    def test_the_simplest_of_equals_is_best(self):
        self.assertEqual(self.choose(("homogeneous", [2, 1]), ("heterogeneous", [1, 2]),
                                     ("bayes", [1.5, 1.5]))[:2], ("homogeneous", "homogeneous"))

    def test_the_second_simplest_can_be_chosen(self):
        self.assertEqual(self.choose(("homogeneous", [9, 9, 9]), ("heterogeneous", [2, 1.2, 2.2]),
                                     ("bdp", [2.1, 1, 2.1]))[:2], ("bdp", "heterogeneous"))

    def test_one_capture_has_no_error(self):
        self.assertEqual(self.choose(("homogeneous", [1.001]), ("bayes", [1]))[1], "bayes")
        self.assertEqual(self.choose(("homogeneous", [1]), ("bayes", [1]))[1], "homogeneous")

    def test_without_models_there_is_none(self):
        self.assertEqual(self.choose()[1], "")

    def test_all_models_need_the_same_captures(self):
        with self.assertRaisesRegex(AssertionError, "other captures"):
            self.choose(("homogeneous", [1, 2]), ("bayes", [1]))


class Tables(unittest.TestCase):
    def tables(self, comparison):
        return compare.make_tables(comparison["runs"], ["homogeneous", "bayes"], ["circle"])

    def test_a_table_for_each_fabric_and_one_for_all(self):
        two, five, all_fabrics = self.tables(make_comparison())
        self.assertEqual((two["choice"]["chosen"], two["choice"]["captures"]), ("bayes", 8))
        self.assertEqual(five["choice"]["chosen"], "homogeneous")
        energy = two["rows"][0]["numbers"]["feature_energy"]
        self.assertEqual(energy["mean"], 3.5)
        self.assertAlmostEqual(energy["sd"], math.sqrt(0.5), 12)
        # Seed 1: (3 + 1)/2, seed 2: (4 + 1)/2.
        self.assertEqual(all_fabrics["fabric"], "all")
        self.assertEqual(all_fabrics["rows"][0]["numbers"]["feature_energy"]["mean"], 2.25)
        self.assertEqual(all_fabrics["choice"]["captures"], 16)
        self.assertEqual(all_fabrics["rows"][2]["model"], "circle")
        self.assertNotIn("elbo", all_fabrics["rows"][0]["numbers"])

    def test_a_capture_that_is_held_out_twice_counts_once(self):
        comparison = make_comparison()
        for run in comparison["runs"]:
            for capture in run["captures"]:
                capture["sample"] = 1
        self.assertEqual(self.tables(comparison)[0]["choice"]["captures"], 4)

    def test_a_model_with_a_failed_run_is_not_chosen(self):
        comparison = make_comparison()
        comparison["runs"][1] = {"fabric": 2, "model": "bayes", "seed": 1,
                                 "failure": "nothing could be fitted"}
        two, _, all_fabrics = self.tables(comparison)
        self.assertEqual(two["choice"]["chosen"], "homogeneous")
        self.assertEqual(two["rows"][1]["failed"], 1)
        self.assertEqual(two["rows"][1]["numbers"]["feature_energy"]["mean"], 1.0)
        self.assertEqual(all_fabrics["rows"][1]["numbers"]["feature_energy"]["seeds"], 1)
        text = compare.table_text(two)
        self.assertIn("bayes (1 of 2 failed)", text)
        self.assertIn("| 3.5 ± 0.71 | 1 | 9 ± 0 |", text)

    def test_posteriors_are_means_over_seeds(self):
        rows = compare.posterior_rows(make_comparison()["runs"], ["homogeneous", "bayes"])
        self.assertEqual([(row["fabric"], row["model"]) for row in rows],
                         [(2, "bayes"), (5, "bayes")])
        self.assertEqual(rows[0]["stretch_n_per_m"], [150, 10])
        self.assertAlmostEqual(rows[0]["bend_n_m"][1], 1e-7, 20)


class Files(unittest.TestCase):
    def write(self, comparison):
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "comparison.json"), "w", encoding="utf-8") as file:
                json.dump(comparison, file)
            with contextlib.redirect_stdout(io.StringIO()):
                compare.tabulate(study.Study(folder, "comparison"))
            files = {}
            for name in os.listdir(folder):
                with open(os.path.join(folder, name), "rb") as file:
                    files[name] = file.read()
            return files

    def test_files_say_the_same(self):
        files = self.write(make_comparison())
        csv, text = files["comparison.csv"].decode(), files["comparison.md"].decode()
        self.assertIn("\n2,homogeneous,feature_energy,3.5,0.707106781,2,2,0\n", csv)
        self.assertIn("\nall,circle,outline_energy_m,0.004,0,2,4,0\n", csv)
        self.assertNotIn("elbo", csv)
        self.assertIn("| held out: energy score of features | 3.5 ± 0.71 | 1 ± 0 | 9 ± 0 |", text)
        self.assertIn("outlines [mm] | 4 ± 0 |", text)
        self.assertIn("**bayes** is the simplest", text)
        self.assertIn("| 2 | bayes | 150 | 10 | 1e-06 | 1e-07 |", text)
        table = json.loads(files["comparison.json"])
        self.assertEqual(table["provenance"]["program"], "drape_compare")
        self.assertEqual(table["tables"][1]["choice"]["chosen"], "homogeneous")

    @unittest.skipIf(study.pyplot is None, "python3-matplotlib is not installed")
    def test_charts_name_models_bounds_and_what_is_not_compared(self):
        comparison = make_comparison()
        comparison["runs"] = [run for run in comparison["runs"] if run["fabric"] == 2]
        for run in comparison["runs"]:
            if run["model"] != "circle":
                run["numbers"].update(rollouts=900, train_mse=0.02, parameters=39, fit_seconds=5)
        whole = self.write(comparison)
        comparison["runs"][1] = {"fabric": 2, "model": "bayes", "seed": 1,
                                 "failure": "nothing could be fitted"}
        lost = self.write(comparison)
        self.assertNotIn(b"not compared", whole["models_fabric_2.svg"])
        self.assertIn(b"a run has no score: not compared", lost["models_fabric_2.svg"])
        for text in (b"bayes", b"homogeneous", b"a circle of their mean area", b"commit abc"):
            self.assertIn(text, whole["held_out_fabric_2.svg"])
        self.assertGreater(len(whole["held_out_fabric_2.png"]), 5000)


if __name__ == "__main__":
    unittest.main()
