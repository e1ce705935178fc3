# SPDX-License-Identifier: Apache-2.0
"""Materials of a table of bending measurements, by hand from its numbers."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[3]
TABLE = """extra, density[kg.m-2], linear warp[SI*1e9], linear weft[SI*1e9], linear diag[SI*1e9], \
nonlinear warp[SI*1e12], nonlinear weft[SI*1e12], nonlinear diag[SI*1e12]
7, 0.1, 1000, 2000, 3000, -10, -20, -30
7, 0.25, 5000.5, 600, 700, 0, 1e3, -1e4
"""


class BendingTable(unittest.TestCase):
    def test_entries_are_the_secant_stiffness(self):
        stretch = ROOT / "configs/fabrics/synthetic_wool.json"
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder) / "set.csv"
            table.write_text(TABLE, encoding="utf-8")
            script = ROOT / "tools/python/examples/bending_table.py"
            done = subprocess.run([sys.executable, "-B", script, table, stretch], check=True,
                                  capture_output=True, text=True)
        bank = json.loads(done.stdout)
        self.assertEqual(list(bank), ["row_1", "row_2"])
        first = bank["row_1"]
        self.assertEqual(first["density"], 0.1)
        expected = [[1e-6, 0.9999e-6, 0.9998e-6, 0.9997e-6, 0.9996e-6],
                    [3e-6, 2.9997e-6, 2.9994e-6, 2.9991e-6, 2.9988e-6],
                    [2e-6, 1.9998e-6, 1.9996e-6, 1.9994e-6, 1.9992e-6]]
        for found, row in zip(first["bend"], expected):
            for a, b in zip(found, row):
                self.assertAlmostEqual(a, b, delta=1e-18)
        wool = json.loads(stretch.read_text(encoding="utf-8"))
        self.assertEqual(first["stretch"], wool["stretch"])


if __name__ == "__main__":
    unittest.main()
