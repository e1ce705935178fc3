# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python module share. The environment names the folders (CMakeLists.txt)."""
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import numpy as np

import drapefit

SOURCE = pathlib.Path(os.environ["DRAPE_SOURCE_DIR"])
BIN = pathlib.Path(os.environ["DRAPE_BIN_DIR"])
WOOL = SOURCE / "configs/fabrics/synthetic_wool.json"
SIX_WAVES = SOURCE / "configs/starts/six_waves.json"


def run_program(name, *options):
    """Runs a program of drapefit, which must succeed."""
    done = subprocess.run([BIN / name, *options], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise AssertionError(f"{name}: {done.stdout}{done.stderr}")


def read_json(path):
    return json.loads(pathlib.Path(path).read_text())


class PythonTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.wool = drapefit.read_material(WOOL)
        cls.simulator = drapefit.Simulator(drapefit.disc(200), threads=2)
        cls.start, _ = cls.simulator.read_start(SIX_WAVES)
        cls.random = np.random.default_rng(5)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def assert_relative(self, found, expected, tolerance):
        """Within that share of the norm of what is expected, which is not zero."""
        scale = np.linalg.norm(expected)
        self.assertGreater(scale, 0.0)
        self.assertLessEqual(np.linalg.norm(np.asarray(found) - expected), tolerance * scale)

    def assert_refused(self, message, call, *arguments, **options):
        with self.assertRaises(ValueError) as caught:
            call(*arguments, **options)
        self.assertIn(message, str(caught.exception))
        self.assertNotIn("\n", str(caught.exception))
