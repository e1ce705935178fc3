# SPDX-License-Identifier: Apache-2.0
"""Samples are compared with fabrics; ways to do so are scored, and multiplied with nested weights
[METHODS, P62]."""

import pathlib
import sys
import unittest

import numpy as np

SCRIPTS = pathlib.Path(__file__).resolve().parents[5] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import space  # noqa: E402


FABRICS, SAMPLES, WITHIN = 6, 40, np.array([[0.5, 0.2], [0.2, 0.3]])
SCALE = np.full(2, 0.5)


def draw_samples(noise):
    """Samples of fabrics on a line, seen with noise."""
    random = np.random.default_rng(4)
    fabric = np.arange(FABRICS * SAMPLES) % FABRICS
    mean = np.stack([2.0 * fabric, 0.0 * fabric], axis=1)
    mean += random.multivariate_normal(np.zeros(2), WITHIN, len(fabric))
    mean += noise * random.standard_normal((len(fabric), 2))
    return mean, np.repeat(noise ** 2 * np.eye(2)[None], len(fabric), axis=0), fabric


class SampleModel(unittest.TestCase):
    def test_separates_the_scatter_of_samples_from_noise(self):
        model = space.SampleModel(*draw_samples(0.5), FABRICS, SCALE)
        self.assertLess(np.linalg.norm(model.within - WITHIN), 0.12)
        for f in range(FABRICS):
            self.assertLess(np.linalg.norm(model.mean[f] - [2.0 * f, 0.0]), 0.4)
            self.assertLess(model.covariance[f][0, 0], 0.05)
        self.assertEqual(model.log_likelihoods(np.array([4.1, 0.1]), 0.01 * np.eye(2)).argmax(), 2)

    def test_a_fabric_without_samples_is_as_the_population(self):
        mean, covariance, fabric = draw_samples(0.1)
        seen = fabric != 5
        model = space.SampleModel(mean[seen], covariance[seen], fabric[seen], FABRICS, SCALE)
        self.assertGreater(model.covariance[5][0, 0], 2.0)

    def test_likelihoods_are_those_of_normal_distributions(self):
        model = space.SampleModel(*draw_samples(0.1), FABRICS, SCALE)
        seen, noise = np.array([1.0, 2.0]), np.array([[0.2, 0.1], [0.1, 0.4]])
        logs = model.log_likelihoods(seen, noise)
        for f in (1, 4):
            total = model.covariance[f] + model.within + noise
            off = seen - model.mean[f]
            density = np.exp(-0.5 * off @ np.linalg.inv(total) @ off) / np.sqrt(np.linalg.det(total))
            self.assertAlmostEqual(logs[f], np.log(density), 10)

    def test_compares_each_sample_with_the_others_alone(self):
        mean, covariance, fabric = (part[:12] for part in draw_samples(0.1))
        seen = [{"mean": m.tolist(), "covariance": c.tolist()} for m, c in zip(mean, covariance)]
        logs = space.compare_with_others(seen, fabric, FABRICS, SCALE)
        others = space.SampleModel(mean[1:], covariance[1:], fabric[1:], FABRICS, SCALE)
        np.testing.assert_array_equal(logs[0], others.log_likelihoods(mean[0], covariance[0]))

    def test_ways_are_those_that_were_seen(self):
        samples = [{"fabric": fabric, "density": 0.1 * (1 + fabric), "predictions": [-1.0, -2.0]}
                   for fabric in (0, 0, 1, 1)]
        by_way, fabric = space.compare({"fabrics": [3, 7], "samples": samples})
        self.assertEqual(list(by_way), ["density", "predictions"])
        self.assertEqual(fabric.tolist(), [0, 0, 1, 1])
        self.assertAlmostEqual(by_way["density"][0, 1], -0.5 * (np.log(2) / 0.03) ** 2, 9)
        self.assertEqual(by_way["density"][2, 1], 0)


class Score(unittest.TestCase):
    def test_ranks_and_losses_are_counted(self):
        logs = np.log([0.1, 0.45, 0.25, 0.2])
        score = space.score(np.array([logs, logs + 7, logs]), np.array([1, 3, 0]))
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
        text = space.text([("way", score)], list("abcd"), [])
        self.assertIn("| way | 3 | 0.333 | 0.667 |", text)
        self.assertIn("| d | 0 of 1 | b: 1 |", text)

    def test_of_equals_the_first_is_more_probable(self):
        score = space.score(np.zeros((2, 2)), np.array([0, 1]))
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
        alone = space.score(half, fabric)["log_loss"]
        both = space.score(space.product([half, other], fabric), fabric)
        with_noise = space.score(space.product([half, noise], fabric), fabric)
        self.assertLess(both["log_loss"], 0.6 * alone)
        self.assertGreater(both["top_1"], 0.8)
        self.assertLess(with_noise["log_loss"], alone + 0.02)
        self.assertGreater(space.score(noise, fabric)["log_loss"], 2.0)

    def test_weights_of_a_sample_come_from_the_others(self):
        """Sample 0 counts for its own weights neither where they help nor where they harm it."""
        logs = np.array([[3.0, 0.0], [1.0, 0.0]])
        true, false = (space.product([logs], np.array([fabric, 0]))[0] for fabric in (0, 1))
        np.testing.assert_array_equal(true, false)
        self.assertLess(false[1], -10.0)  # the other sample is right, so the way is trusted

    def test_rows_need_all_their_ways(self):
        by_way = {"features": np.eye(3), "predictions": 2 * np.eye(3)}
        rows = space.score_rows(by_way, np.arange(3))
        self.assertEqual([way for way, _ in rows],
                         ["image features", "predicted drapes (B)", "B and features"])


if __name__ == "__main__":
    unittest.main()
