# SPDX-License-Identifier: Apache-2.0
"""Derivatives of drapes in Python: against differences, one another and the programs."""
import json
import unittest

import numpy as np

import drapefit
from python_fixture import SIX_WAVES, WOOL, PythonTest, run_program

STEPS = {"h": 0.05, "steps": 20}
READOUTS = ("positions", "outline", "features", "silhouette")


class DerivativesTest(PythonTest):
    def inputs(self, factors=7, batch=2):
        """Factors, starts, velocities and dynamics of a batch, and a direction in each."""
        shape = self.start.shape
        values = (0.1 * self.random.normal(size=(batch, factors)),
                  self.start + 1e-3 * self.random.normal(size=(batch, *shape)),
                  1e-2 * self.random.normal(size=(batch, *shape)),
                  np.array([1.0, 0.02, 0.4, 1.0, 0.0, 0.5]) * self.random.uniform(1, 2, (batch, 6)))
        scales = (1.0, 1e-3, 1.0, np.array([0.1, 2e-3, 0.1, 0.1, 0.1, 0.1]))
        return values, [s * self.random.normal(size=v.shape) for s, v in zip(scales, values)]

    def drape(self, inputs, **options):
        return self.simulator.drape(self.wool, *inputs, **{**STEPS, **options})

    def differences(self, inputs, direction, of, step=1e-5, **options):
        """Their error is least at this step: 4e-7 for those by the start, less for others."""
        ends = [self.drape([v + sign * step * d for v, d in zip(inputs, direction)], **options)
                for sign in (1, -1)]
        return (ends[0].read(of) - ends[1].read(of)) / (2 * step)

    def test_jvp_and_vjp_are_central_differences_to_1e_minus_6(self):
        inputs, direction = self.inputs()
        drapes = self.drape(inputs)
        for of in READOUTS:
            for part, name in enumerate(drapefit.Gradient._fields):
                one = [d if k == part else 0 * d for k, d in enumerate(direction)]
                with self.subTest(of=of, by=name):
                    differences = self.differences(inputs, one, of)
                    jvp = drapes.jvp(*one, of=of)
                    if of == "features":  # folds, a whole number, has none
                        np.testing.assert_array_equal(jvp[:, 1], 0.0)
                        differences[:, 1] = 0.0
                    self.assert_relative(jvp, differences, 1e-6)
                    cotangent = self.random.normal(size=jvp.shape)
                    gradient = drapes.vjp(cotangent, of=of)[part]
                    self.assertAlmostEqual(np.vdot(gradient, one[part]),
                                           np.vdot(cotangent, differences),
                                           delta=1e-6 * np.linalg.norm(cotangent)
                                           * np.linalg.norm(differences))

    def test_derivatives_of_frames_are_central_differences_to_1e_minus_6(self):
        inputs, direction = self.inputs()
        options = {"frames": [0, 7, 20]}
        drapes = self.drape(inputs, record=True, **options)
        for of in ("frames", "frame_velocities"):
            for part, name in enumerate(drapefit.Gradient._fields):
                one = [d if k == part else 0 * d for k, d in enumerate(direction)]
                with self.subTest(of=of, by=name):
                    differences = self.differences(inputs, one, of, **options)
                    jvp = drapes.jvp(*one, of=of)
                    self.assertEqual(jvp.shape, (2, 3, *self.start.shape))
                    self.assert_relative(jvp, differences, 1e-6)
                    cotangent = self.random.normal(size=jvp.shape)
                    gradient = drapes.vjp(cotangent, of=of)[part]
                    self.assertAlmostEqual(np.vdot(gradient, one[part]), np.vdot(cotangent, jvp),
                                           delta=1e-10 * np.linalg.norm(cotangent)
                                           * np.linalg.norm(jvp))

    def test_vjp_is_the_transpose_of_jvp_to_1e_minus_10(self):
        for solve in ("dynamic", "hybrid"):
            inputs, direction = self.inputs(factors=39)
            drapes = self.drape(inputs, solve=solve, h=0.1, steps=60 if solve == "hybrid" else 20)
            self.assertTrue(drapes.found.all(), drapes.status)
            for of in READOUTS:
                with self.subTest(of=of, solve=solve):
                    jvp = drapes.jvp(*direction, of=of)
                    cotangent = self.random.normal(size=jvp.shape)
                    gradient = drapes.vjp(cotangent, of=of)
                    found = sum(np.vdot(g, d) for g, d in zip(gradient, direction))
                    scale = np.linalg.norm(cotangent) * np.linalg.norm(jvp)
                    self.assertLess(abs(found - np.vdot(cotangent, jvp)), 1e-10 * scale)

    def test_equilibria_move_as_differences_say(self):
        (factors, start, *_), _ = self.inputs(factors=2)
        options = {"solve": "hybrid", "h": 0.1, "steps": 100}
        drapes = self.simulator.drape(self.wool, factors, start, **options)
        self.assertTrue(drapes.found.all(), drapes.status)
        self.assertLess(drapes.residual.max(), 1e-8)
        unit = np.array([0.0, 1e-4])
        ends = [self.simulator.drape(self.wool, factors + sign * unit, drapes.positions, steps=0,
                                     solve="hybrid").positions for sign in (1, -1)]
        self.assert_relative(drapes.jvp(unit), (ends[0] - ends[1]) / 2, 1e-3)
        gradient = drapes.vjp(np.ones_like(start))
        np.testing.assert_array_equal(gradient.start, 0.0)
        np.testing.assert_array_equal(gradient.dynamics, 0.0)


if __name__ == "__main__":
    unittest.main()
