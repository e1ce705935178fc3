# SPDX-License-Identifier: Apache-2.0
"""The examples of tools/python recover what they look for."""
import importlib.util
import re
import subprocess
import sys
import unittest

import numpy as np

import drapefit
from python_fixture import SIX_WAVES, SOURCE, WOOL, PythonTest, run_program

EXAMPLES = SOURCE / "tools/python/examples"


def has(module):
    return importlib.util.find_spec(module) is not None


def run_example(name, *arguments):
    done = subprocess.run([sys.executable, EXAMPLES / name, *arguments], capture_output=True,
                          text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{name}: {done.stdout}{done.stderr}")
    return done.stdout


class ExamplesTest(PythonTest):
    @unittest.skipUnless(has("scipy"), "no scipy here")
    def test_scipy_fits_one_silhouette(self):
        wool = self.wool
        stiff = drapefit.make_material(wool.density, wool.stretch, 2.0 * wool.bend)
        stiff.write(str(self.folder / "stiff.json"))
        run_program("drape_simulate", "--mesh=disc:1200", "--solve=hybrid", "--time_step=0.1",
                    f"--fabric={self.folder / 'stiff.json'}", f"--start={SIX_WAVES}",
                    f"--out={self.folder / 'drape'}")
        fitted = self.folder / "fitted.json"
        said = run_example("fit_silhouette.py", self.folder / "drape/silhouette.png", WOOL, fitted)
        ratio = drapefit.read_material(fitted).bend / stiff.bend
        self.assertLess(abs(np.log(ratio)).max(), np.log(1.15), said)
        # Folds turn from mesh to mesh.
        self.assertLess(float(re.search(r"to ([0-9.]+) px", said).group(1)), 4.0)
        self.assertLessEqual(len((EXAMPLES / "fit_silhouette.py").read_text().splitlines()), 30)

    @unittest.skipUnless(has("torch"), "no torch here")
    def test_torch_recovers_factors(self):
        said = run_example("torch_layer.py", WOOL)
        found, known = (np.array(re.findall(r"-?[0-9.]+(?:e-?[0-9]+)?", part)[:2], float)
                        for part in re.search(r"factors (.*), known (.*), loss", said).groups())
        self.assertLess(np.abs(found - known).max(), 1e-4, said)


if __name__ == "__main__":
    found = unittest.main(exit=False).result
    for test, reason in found.skipped:
        print(f"{test.id()}: Skipped\n{reason}")
    sys.exit(1 if not found.wasSuccessful() else 77 if found.skipped else 0)
