# SPDX-License-Identifier: Apache-2.0
"""compare_optimisers.py: scores of runs that are made up."""
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[5] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import compare_optimisers as scores  # noqa: E402


def cell(problem, method, trace, at=0, seed=0, numbers=7, **more):
    return {"name": f"{problem}.{method}", "input": {
        "problem": problem, "method": method, "seed": seed, "num_parameters": numbers}, "result": {
        "trace": trace, "shape_um": [at] * 6, "spent": trace[-1][0], "evaluations": 8, "jacobians": 0,
        "failed": 2, "cpu_s": 1.0, "function_cpu_s": 1.0, "jacobian_cpu_s": 0.0, "rms_px": 2.0,
        "settled_rms_px": 2.0, "coupling": 0.1, **more}}


# Costs 100 -> 10 and 100 -> 19 (within a tenth) on a, 50 -> 40 and 50 -> 20 on b, on other branches.
PAIR = [cell("a", "quick", [[1, 0.1, 100], [4, 0.4, 10]]),
        cell("a", "slow", [[1, 0.2, 100], [8, 1.2, 19]], at=100),
        cell("b", "quick", [[1, 0.1, 50], [6, 0.7, 40]]),
        cell("b", "slow", [[1, 0.2, 50], [9, 1.8, 20]], at=100000)]
# One problem, 100 -> 10 by a method without seeds; two seeds of another end at 11 and 60.
OWN = {"cpu_s": 2.0, "function_cpu_s": 0.5}
SEEDS = [cell("a", "lm", [[1, 0.1, 100], [4, 0.4, 10]]),
         cell("a", "bo", [[1, 0.1, 100], [7, 1.0, 60], [9, 1.5, 11]], seed=1, **OWN),
         cell("a", "bo", [[1, 0.1, 100], [8, 1.2, 60]], seed=2, **OWN)]


def race(cells):
    return scores.Race([scores.Run(one) for one in cells])


class ScoresTest(unittest.TestCase):
    def test_scores_of_made_up_traces(self):
        pair = race(PAIR)
        quick, slow = scores.method_rows(pair)
        self.assertEqual(quick[:5], ["quick", "0.50", "0.50", "0.50", "0.50"])
        self.assertEqual(slow[:5], ["slow", "1.00", "0.50", "0.50", "1.00"])
        self.assertEqual(quick[5], "0.3333 [0.1667, 0.5000]")  # of 0 and 20/30
        self.assertEqual(quick[9], "0.25")
        self.assertEqual(pair.spent_to_solve("quick", 0.1), [4, math.inf])
        self.assertEqual(pair.spent_to_solve("slow", 0.1), [8, 9])
        self.assertEqual(pair.spent_to_solve("slow", 0.1, 1), [1.2, 1.8])
        ratios = scores.ratios(pair, 0.1, 0)
        self.assertEqual(list(ratios["quick"]), [1, math.inf])
        self.assertEqual(list(ratios["slow"]), [2, 1])

    def test_seeds_are_runs_of_their_own(self):
        seeds = race(SEEDS)
        lm, bo = scores.method_rows(seeds)
        self.assertEqual((lm[1], bo[1], bo[9], bo[11]), ("1.00", "0.50", "0.25", "1.5"))
        first, second = 1 / 90, 50 / 90
        low, middle, high = scores.quartiles(seeds.gaps_at("bo", 9))
        self.assertAlmostEqual(middle, (first + second) / 2)
        self.assertAlmostEqual(low, 0.75 * first + 0.25 * second)
        self.assertAlmostEqual(high, 0.25 * first + 0.75 * second)
        self.assertAlmostEqual(scores.quartiles(seeds.gaps_at("bo", 8))[0], second)
        self.assertEqual(seeds.spent_to_reach_lm("lm"), [4, 4])
        self.assertEqual(seeds.spent_to_reach_lm("bo"), [9, math.inf])  # 11 = 1.1 · 10

    def test_quartiles_interpolate_and_keep_infinity(self):
        never = math.inf
        self.assertEqual(scores.quartiles([5, 1, 4, 2, 3]), [2, 3, 4])
        self.assertEqual(scores.quantile([1, 2], 0.25), 1.25)
        self.assertEqual(scores.quartiles([1, 2, 3, never, never])[1:], [3, never])
        self.assertEqual(scores.quantile([never, never], 0.25), never)

    def test_a_jacobian_costs_what_it_took(self):
        runs = [scores.Run(cell("a", "lm", [[1, 0, 1]], jacobians=4, evaluations=8,
                                function_cpu_s=10.0, jacobian_cpu_s=2.0))]
        self.assertEqual(scores.jacobian_cost(runs), 0.5)  # 2/4 by 8/8
        self.assertEqual(scores.jacobian_cost([scores.Run(one) for one in PAIR]), 0)

    def test_writes_tables_and_charts_and_leaves_out_problems_without_a_start(self):
        failed = {"name": "c.quick", "input": {"problem": "c", "method": "quick", "seed": 0,
                                               "num_parameters": 7}, "result": {"failure": "none"}}
        with tempfile.TemporaryDirectory() as folder:
            pathlib.Path(folder, "compare_optimisers.json").write_text(json.dumps({
                "settings": {"budget_rollouts": 10, "jacobian_cost_units": 1}, "checkpoints": [5, 60],
                "cells": PAIR + [failed]}))
            done = subprocess.run([sys.executable, "-B", SCRIPTS / "compare_optimisers.py", folder],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertTrue(done.stdout.startswith("c: left out"), done.stdout)
            self.assertIn("\nquick ", done.stdout)
            study = json.loads(pathlib.Path(folder, "compare_optimisers.json").read_text())
            self.assertEqual([method["name"] for method in study["methods"]], ["quick", "slow"])
            self.assertEqual(study["methods"][1]["solved_at_0.1"], 1)
            self.assertEqual(study["cells"], PAIR + [failed])
            report = pathlib.Path(folder, "report.md").read_text()
            self.assertIn("| method | gap at 5 | gap at 10 |", report)
            self.assertIn("| a | 100 | **10** (2.00 px) | 19 (2.00 px) |", report)
            self.assertEqual(len(pathlib.Path(folder, "traces.csv").read_text().splitlines()), 9)
            for chart in ("convergence", "profiles", "data_profiles", "branches"):
                for kind in ("svg", "png"):
                    self.assertGreater(pathlib.Path(folder, f"{chart}.{kind}").stat().st_size, 1000)


if __name__ == "__main__":
    unittest.main()
