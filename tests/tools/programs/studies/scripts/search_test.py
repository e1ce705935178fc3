# SPDX-License-Identifier: Apache-2.0
"""search.py: Gaussian process, Bayesian optimisation, embeddings and CMA-ES on known functions."""
import pathlib
import subprocess
import sys
import unittest

import numpy
import scipy.optimize

SCRIPTS = pathlib.Path(__file__).resolve().parents[5] / "tools/programs/studies/scripts"
sys.path.insert(0, str(SCRIPTS))
import search  # noqa: E402


def run(method, function, size, budget, seed=1, bound=3.0):
    """The proposals and their costs."""
    proposals = search.make_search(method, size, bound, seed)
    points, costs = [next(proposals)], []
    while True:
        costs.append(function(points[-1]))
        if len(costs) == budget:
            return numpy.array(points), numpy.array(costs)
        try:
            points.append(proposals.send(costs[-1]))
        except StopIteration:
            return numpy.array(points), numpy.array(costs)


def ellipsoid(x):
    return float(10 ** numpy.linspace(0, 3, len(x)) @ (x - 0.7) ** 2)


class ProcessTest(unittest.TestCase):
    def setUp(self):
        random = numpy.random.default_rng(0)
        self.points = random.uniform(-1, 1, (12, 2))
        self.values = numpy.sin(3 * self.points[:, 0]) + self.points[:, 1]
        self.here = numpy.array([0.1, 0.2, -0.3, -2.0])

    def test_gradient_of_the_density_is_that_of_differences(self):
        for squared_exponential in (False, True):
            process = search.Process(squared_exponential, numpy.array([0, 0, 0, -2.0]))
            value = lambda here: process.negative_log_density(here, self.points, self.values)
            error = scipy.optimize.check_grad(lambda h: value(h)[0], lambda h: value(h)[1], self.here)
            self.assertLess(error, 1e-4)

    def test_one_observation_has_the_closed_form(self):
        # k = s² (1 + r + r²/3) e^-r with r = √5 |x|/l; mean k y/(s² (1 + nugget) + σ²).
        process = search.Process(False, numpy.array([numpy.log(2), numpy.log(0.5), numpy.log(0.1)]))
        mean, deviation = process.predict(numpy.zeros((1, 1)), numpy.array([3.0]), numpy.array([[0.4]]))
        r = numpy.sqrt(5) * 0.4 / 0.5
        k = 4 * (1 + r + r * r / 3) * numpy.exp(-r)
        diagonal = 4 * (1 + 1e-8) + 0.01
        self.assertAlmostEqual(mean[0], k * 3 / diagonal, places=12)
        self.assertAlmostEqual(deviation[0], numpy.sqrt(4 - k * k / diagonal), places=12)

    def test_fit_finds_a_denser_place_and_interpolates(self):
        process = search.Process(False, numpy.array([0, 0, 0, -3.5]))
        before = process.negative_log_density(process.here, self.points, self.values)[0]
        process.fit(self.points, self.values)
        self.assertLess(
            process.negative_log_density(process.here, self.points, self.values)[0], before - 1)
        mean, deviation = process.predict(self.points, self.values, self.points)
        self.assertLess(abs(mean - self.values).max(), 0.1)
        self.assertLess(deviation.max(), 0.2)

    def test_equal_points_raise_the_noise_instead_of_failing(self):
        process = search.Process(True, numpy.array([0, 5, 5, -30.0]))
        points = numpy.repeat(self.points[:1], 40, axis=0)
        mean, _ = process.predict(points, numpy.ones(40), points[:1])
        self.assertAlmostEqual(mean[0], 1, places=3)


class SearchTest(unittest.TestCase):
    METHODS = ("cmaes", "bo", "rembo_2", "rembo_ucb_4", "hesbo_4")

    def test_begins_at_0_stays_in_the_box_and_follows_its_seed(self):
        for method in self.METHODS:
            points, _ = run(method, ellipsoid, 7, 30)
            self.assertTrue((points[0] == 0).all(), method)
            self.assertLessEqual(abs(points).max(), 3, method)
            self.assertTrue((run(method, ellipsoid, 7, 30)[0] == points).all(), method)
            self.assertFalse((run(method, ellipsoid, 7, 30, seed=2)[0] == points).all(), method)

    def test_cmaes_converges_on_an_ellipsoid(self):
        points, costs = run("cmaes", ellipsoid, 7, 5000)
        self.assertLess(len(costs), 5000)
        self.assertLess(costs.min(), 1e-14)
        self.assertLess(abs(points[costs.argmin()] - 0.7).max(), 1e-6)

    def test_cmaes_halves_its_step_where_nothing_can_be_evaluated(self):
        points, _ = run("cmaes", lambda x: numpy.inf if x.any() else 1.0, 4, 1 + 8 * 20)
        self.assertLess(abs(points[-8:]).max(), 1e-3 * abs(points[1:9]).max())

    def test_bayesian_optimisation_finds_the_minimum_of_two_numbers(self):
        # Failures count as the largest cost so far.
        points, costs = run("bo", lambda x: numpy.inf if x[0] < -1 else ellipsoid(x) + 1e-3, 2, 60)
        self.assertLess(costs.min(), 0.5)
        self.assertLess(numpy.isinf(costs[-20:]).sum(), 10)

    def test_hesbo_copies_each_number_with_a_sign(self):
        points, _ = run("hesbo_4", ellipsoid, 39, 20)
        sizes = [len({round(abs(x), 9) for x in point}) for point in points[1:]]
        self.assertLessEqual(max(sizes), 4)

    def test_rembo_searches_a_plane_clipped_to_the_box(self):
        points, _ = run("rembo_2", ellipsoid, 39, 40)
        inside = [point for point in points if abs(point).max() < 3]
        self.assertGreater(len(inside), 2)
        self.assertEqual(numpy.linalg.matrix_rank(numpy.array(inside), tol=1e-9), 2)
        self.assertTrue((abs(points) == 3).any())

    def test_costs_are_standardised_by_their_logarithms(self):
        values = search.standardised(numpy.array([1.0, numpy.e, numpy.inf]))
        self.assertAlmostEqual(values.mean(), 0)
        self.assertAlmostEqual(values.std(), 1)
        self.assertEqual(values[1], values[2])
        self.assertLess(values[0], values[1])
        self.assertTrue((search.standardised(numpy.full(3, 2.0)) == 0).all())

    def test_speaks_in_lines(self):
        process = subprocess.Popen([sys.executable, SCRIPTS / "search.py", "cmaes", "2", "3", "5"],
                                   stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        out, _ = process.communicate("1\nnone\n2\n")
        lines = [[float(word) for word in line.split()] for line in out.splitlines()]
        self.assertEqual(process.returncode, 0)
        self.assertEqual(len(lines), 4)
        self.assertEqual(lines[0][1:], [0, 0])
        self.assertTrue(all(len(line) == 3 and line[0] >= 0 for line in lines))


if __name__ == "__main__":
    unittest.main()
