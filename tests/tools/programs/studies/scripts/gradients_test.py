# SPDX-License-Identifier: Apache-2.0
"""How a gradient grows towards the end of a branch."""

import pathlib
import sys
import unittest

SCRIPTS = pathlib.Path(__file__).resolve().parents[5] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import gradients  # noqa: E402


class Approach(unittest.TestCase):
    def test_a_fold_has_its_exponents(self):
        """x = (s* - s)^½ at s* = 0.3: the speed is ½(s* - s)^-½, the eigenvalue goes as (s* - s)^½."""
        points = [{"s": s, "speed_m": 0.5 / (0.3 - s) ** 0.5, "lowest_eigenvalue": 40 * (0.3 - s) ** 0.5}
                  for s in (0.0, 0.25, 0.291, 0.298, 0.2999)]
        branch = gradients.find_approach({"points": points, "fold_estimate": 0.3})
        self.assertEqual(len(branch["approach"]["speed_m"]), 3)  # near the largest speed
        self.assertAlmostEqual(branch["exponent_by_distance"], -0.5, 9)
        self.assertAlmostEqual(branch["exponent_by_eigenvalue"], -1.0, 9)

    def test_a_branch_without_a_fold_has_none(self):
        branch = {"points": [{"s": 0.0, "speed_m": 1.0, "lowest_eigenvalue": None}]}
        self.assertEqual(gradients.find_approach(branch), branch)
        alone = gradients.find_approach({**branch, "fold_estimate": 0.3})
        self.assertNotIn("exponent_by_distance", alone)


if __name__ == "__main__":
    unittest.main()
