# SPDX-License-Identifier: Apache-2.0
"""Ways to recognise fabrics are scored, and multiplied with nested weights [METHODS, P62]."""

import pathlib
import sys
import unittest

import numpy as np

SCRIPTS = pathlib.Path(__file__).resolve().parents[4] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import recognition  # noqa: E402


class Score(unittest.TestCase):
    def test_ranks_and_losses_are_counted(self):
        logs = np.log([0.1, 0.45, 0.25, 0.2])
        score = recognition.score(np.array([logs, logs + 7, logs]), np.array([1, 3, 0]))
        self.assertEqual(score["samples"], 3)
        self.assertAlmostEqual(score["top_1"], 1 / 3, 15)
        self.assertAlmostEqual(score["top_3"], 2 / 3, 15)
        self.assertAlmostEqual(score["log_loss"], -np.log([0.45, 0.2, 0.1]).mean(), 12)
        self.assertEqual(score["confusion"][3, 1], 1)
        self.assertEqual(score["confusion"][1, 1], 1)
        (count, sure, right), = score["reliability"]
        self.assertEqual(count, 3)
        self.assertAlmostEqual(sure, 0.45, 12)
        self.assertAlmostEqual(right, 1 / 3, 15)
        text = recognition.text([("way", score)], list("abcd"), [])
        self.assertIn("| way | 3 | 0.333 | 0.667 |", text)
        self.assertIn("| d | 0 of 1 | b: 1 |", text)

    def test_of_equals_the_first_is_more_probable(self):
        score = recognition.score(np.zeros((2, 2)), np.array([0, 1]))
        self.assertEqual(score["top_1"], 0.5)


class Product(unittest.TestCase):
    def test_a_product_takes_what_helps(self):
        """One way is noise; two halves of what there is to know are better together."""
        random = np.random.default_rng(3)
        fabric = np.arange(120) % 4
        all_fabrics = np.arange(4)
        half = 2.0 * (all_fabrics // 2 == fabric[:, None] // 2) + 0.5 * random.normal(size=(120, 4))
        other = 2.0 * (all_fabrics % 2 == fabric[:, None] % 2) + 0.5 * random.normal(size=(120, 4))
        noise = 8.0 * random.normal(size=(120, 4))
        alone = recognition.score(half, fabric)["log_loss"]
        both = recognition.score(recognition.product([half, other], fabric), fabric)
        with_noise = recognition.score(recognition.product([half, noise], fabric), fabric)
        self.assertLess(both["log_loss"], 0.6 * alone)
        self.assertGreater(both["top_1"], 0.8)
        self.assertLess(with_noise["log_loss"], alone + 0.02)
        self.assertGreater(recognition.score(noise, fabric)["log_loss"], 2.0)

    def test_weights_of_a_sample_come_from_the_others(self):
        """Sample 0 counts for its own weights neither where they help nor where they harm it."""
        logs = np.array([[3.0, 0.0], [1.0, 0.0]])
        true, false = (recognition.product([logs], np.array([fabric, 0]))[0] for fabric in (0, 1))
        np.testing.assert_array_equal(true, false)
        self.assertLess(false[1], -10.0)  # the other sample is right, so the way is trusted

    def test_rows_need_all_their_ways(self):
        by_way = {"features": np.eye(3), "predictions": 2 * np.eye(3)}
        rows = recognition.score_rows(by_way, np.arange(3))
        self.assertEqual([way for way, _ in rows],
                         ["image features", "predicted drapes (B)", "B and features"])


if __name__ == "__main__":
    unittest.main()
