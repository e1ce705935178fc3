# SPDX-License-Identifier: Apache-2.0
"""recovery.py on summaries that are made up."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[4] / "tools/programs/fit/recovery.py"
KEYS = ("c11_n_per_m", "c12_n_per_m", "c22_n_per_m", "c33_n_per_m", "bend_along_weft_n_m",
        "bend_at_45_deg_n_m", "bend_along_warp_n_m")
SHEET = ("bending_in_drape_un_m", "bending_warp_un_m", "bending_weft_un_m", "bending_overall_un_m")


class RecoveryTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, grade, ratio, reference=4.0):
        quantity = {"fitted": 4.0 * ratio} | ({"reference": reference} if reference else {})
        path = self.folder / name / "summary.json"
        path.parent.mkdir()
        path.write_text(json.dumps({
            "verdict": {"grade": grade, },
            "laboratory": {
                "material": {"rows": [{"key": key, "value": 4 * ratio, "low": 3.0, "high": 7.68}
                                      for key in SHEET]},
                "reference": {"rows": [{"key": key, "value": reference * (ratio == 1.0 or 2)}
                                       for key in SHEET] if reference else []}},
            "stiffness": {key: quantity for key in KEYS}}))

    def run_script(self):
        folders = sorted(str(path) for path in self.folder.iterdir() if path.is_dir())
        return subprocess.run(
            [sys.executable, SCRIPT, f"--out={self.folder}/chart.png"] + folders,
            capture_output=True, text=True)

    def test_quantiles_interpolate_and_bad_fits_are_left_out(self):
        for name, grade, ratio in (("a", "good", 2.0), ("b", "usable", 0.5), ("c", "good", 1.0),
                                   ("d", "do not use", 9.0)):
            self.write(name, grade, ratio)
        done = self.run_script()
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        self.assertEqual(lines[0],
                         "3 fits of known fabrics, 1 more left out as not to be used")
        rows = {line[:24].strip(): line[24:].split() for line in lines[2:]}
        self.assertEqual(len(rows), 8)
        self.assertEqual(rows["stretch c11"], ["0.55", "1.00", "1.90"])
        for name in ("B, as it drapes", "B, overall", "B, warp", "B, weft"):
            self.assertEqual(rows[name], ["0.33", "1.00", "1.00", "to", "1.60", "x", "33", "%"])
        self.assertEqual(len(rows["shear c33"]), 3)
        self.assertGreater((self.folder / "chart.png").stat().st_size, 1000)

    def test_refuses_what_is_no_fit_of_a_known_fabric(self):
        self.write("a", "good", 1.0, reference=None)
        done = self.run_script()
        self.assertEqual(done.returncode, 2)
        self.assertIn("found no 'reference', expected a fit with --ground_truth", done.stderr)
        self.assertEqual(len(done.stderr.splitlines()), 1)

    def test_refuses_folders_without_a_usable_fit(self):
        self.write("a", "do not use", 1.0)
        done = self.run_script()
        self.assertEqual(done.returncode, 2)
        self.assertIn("none of 1 fits is usable", done.stderr)
        (self.folder / "a" / "summary.json").unlink()
        self.assertIn("summary.json", self.run_script().stderr)


if __name__ == "__main__":
    unittest.main()
