# SPDX-License-Identifier: Apache-2.0
"""Drapes and gradients of a GPU in Python, against the CPU's. Skipped, with the reason, without."""
import sys
import unittest

import numpy as np

import drapefit
from python_fixture import PythonTest

READOUTS = ("positions", "outline", "silhouette")


class CudaTest(PythonTest):
    def setUp(self):
        super().setUp()
        self.device = drapefit.Simulator(drapefit.disc(200), backend="cuda")
        self.factors = 0.1 * self.random.normal(size=(5, 39))
        self.starts = self.start + 1e-3 * self.random.normal(size=(5, *self.start.shape))

    def drape(self, simulator, **options):
        return simulator.drape(self.wool, self.factors, self.starts, **options)

    def test_drapes_are_those_of_the_cpu(self):
        for options in ({"h": 0.05, "steps": 40}, {"h": 0.1, "steps": 60, "solve": "hybrid"}):
            with self.subTest(**options):
                expected, found = (self.drape(s, **options) for s in (self.simulator, self.device))
                self.assertTrue(expected.found.all() and found.found.all())
                np.testing.assert_allclose(found.positions, expected.positions, rtol=0, atol=1e-9)

    def test_gradients_are_those_of_the_cpu(self):
        expected, found = (self.drape(s, h=0.05, steps=20) for s in (self.simulator, self.device))
        for of in READOUTS:
            cotangent = self.random.normal(size=expected.read(of).shape)
            for name, one, other in zip(drapefit.Gradient._fields, found.vjp(cotangent, of=of),
                                        expected.vjp(cotangent, of=of)):
                with self.subTest(of=of, by=name):
                    self.assert_relative(one, other, 1e-8)


if __name__ == "__main__":
    try:
        drapefit.Simulator(drapefit.disc(200), backend="cuda")
    except RuntimeError as error:
        print("needs a GPU:", error)
        sys.exit(77)
    unittest.main()
