# SPDX-License-Identifier: Apache-2.0
"""Searches without derivatives for drape_compare_optimisers, which starts this program.

usage: search.py METHOD NUMBERS BOUND SEED

METHOD is cmaes, bo, rembo_<d>, rembo_ucb_<d> or hesbo_<d> (d numbers of the embedding). The search
is in the box |x_i| <= BOUND and begins at 0. It prints one proposal a line, the CPU seconds that it
took and then the numbers, and reads the cost of each from one line: a number >= 0, or "none" where
the function cannot be evaluated. It ends when it has converged or the input ends.
"""

import os
import sys
import time

os.environ["OPENBLAS_NUM_THREADS"] = "1"  # a run has one core; the bits do not depend on cores

import numpy
import scipy.linalg
import scipy.optimize
import scipy.special
import scipy.stats


def cmaes(size, bound, random):
    """(mu/mu_w, lambda)-CMA-ES with the defaults of [Hansen 2016, appendix A], whose names these
    are, without negative weights. A sample outside the box is drawn again up to ten times, then
    clipped. In a generation that cannot be evaluated at all the step size is halved."""
    n, count = size, 4 + int(3 * numpy.log(size))
    weights = numpy.log(0.5 * (count + 1)) - numpy.log(numpy.arange(1, count // 2 + 1))
    weights /= weights.sum()
    mu_eff = 1 / (weights**2).sum()
    c_sigma = (mu_eff + 2) / (n + mu_eff + 5)
    d_sigma = 1 + 2 * max(0, numpy.sqrt((mu_eff - 1) / (n + 1)) - 1) + c_sigma
    c_c = (4 + mu_eff / n) / (n + 4 + 2 * mu_eff / n)
    c_1 = 2 / ((n + 1.3) ** 2 + mu_eff)
    c_mu = min(1 - c_1, 2 * (0.25 + mu_eff + 1 / mu_eff - 2) / ((n + 2) ** 2 + mu_eff))
    chi = numpy.sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n))  # the mean of |N(0, 1)|
    mean, path_sigma, path_c = numpy.zeros((3, n))
    covariance = axes = numpy.eye(n)
    deviations, step_size, generation = numpy.ones(n), bound / 3, 0
    yield mean

    def sample():
        for _ in range(10):
            point = mean + step_size * axes @ (deviations * random.standard_normal(n))
            if abs(point).max() <= bound:
                return point
        return numpy.clip(point, -bound, bound)

    while True:
        samples, costs = [], []
        for _ in range(count):
            samples.append(sample())
            costs.append((yield samples[-1]))
        if not numpy.isfinite(costs).any():
            step_size *= 0.5
            continue
        generation += 1
        best = numpy.argsort(costs, kind="stable")[: len(weights)]
        steps = (numpy.array(samples)[best] - mean) / step_size
        step = weights @ steps
        mean = mean + step_size * step
        whitened = axes @ (axes.T @ step / deviations)
        path_sigma = (1 - c_sigma) * path_sigma + numpy.sqrt(
            c_sigma * (2 - c_sigma) * mu_eff) * whitened
        length = numpy.linalg.norm(path_sigma)
        steady = numpy.sqrt(1 - (1 - c_sigma) ** (2 * generation))
        moves = length / steady < (1.4 + 2 / (n + 1)) * chi
        path_c = (1 - c_c) * path_c
        if moves:
            path_c = path_c + numpy.sqrt(c_c * (2 - c_c) * mu_eff) * step
        forgotten = 0 if moves else c_1 * c_c * (2 - c_c)
        covariance = ((1 + forgotten - c_1 - c_mu) * covariance + c_1 * numpy.outer(path_c, path_c)
                      + c_mu * (steps.T * weights) @ steps)
        step_size *= numpy.exp(c_sigma / d_sigma * (length / chi - 1))
        values, axes = numpy.linalg.eigh(0.5 * (covariance + covariance.T))
        if not values[0] > 0 or values[-1] > 1e14 * values[0]:
            return
        deviations = numpy.sqrt(values)
        if step_size * deviations[-1] < 1e-9:
            return


class Process:
    """Regression by a Gaussian process of mean 0 with observation noise [Rasmussen 2006, chapters 2
    and 5]. Its hyperparameters are ln s, ln l_1 ... ln l_d and ln sigma: covariance s^2 k(r), r the
    distance by the lengths l, k Matern 5/2 (eq. 4.17) or squared exponential (eq. 4.9)."""

    NUGGET = 1e-8  # of s^2

    def __init__(self, squared_exponential, start):
        self.squared_exponential = squared_exponential
        self.prior_mean = self.here = start

    def kernel(self, a, b, here):
        """The correlation of the rows of a and b, and -2 times its derivative by r^2."""
        a, b = a / numpy.exp(here[1:-1]), b / numpy.exp(here[1:-1])
        squares = numpy.maximum((a**2).sum(1)[:, None] + (b**2).sum(1) - 2 * a @ b.T, 0)
        if self.squared_exponential:
            value = numpy.exp(-0.5 * squares)
            return value, value
        r = numpy.sqrt(5 * squares)
        return (1 + r + r**2 / 3) * numpy.exp(-r), 5 / 3 * (1 + r) * numpy.exp(-r)

    def factor(self, points, here):
        covariance = numpy.exp(2 * here[0]) * self.kernel(points, points, here)[0]
        covariance[numpy.diag_indices(len(points))] = numpy.exp(2 * here[0]) * (
            1 + self.NUGGET) + numpy.exp(2 * here[-1])
        return scipy.linalg.cholesky(covariance, lower=True)

    def negative_log_density(self, here, points, values):
        """-ln p(values | here) p(here) and its gradient [Rasmussen 2006, eq. 2.30 and 5.9]. The
        prior, a standard deviation of 3 on each, keeps directions without influence finite."""
        off = (here - self.prior_mean) / 3
        try:
            lower = self.factor(points, here)
        except (numpy.linalg.LinAlgError, ValueError):
            return 1e10, numpy.zeros_like(here)
        weights = scipy.linalg.cho_solve((lower, True), values)
        cost = (0.5 * off @ off + 0.5 * values @ weights + numpy.log(numpy.diag(lower)).sum()
                + 0.5 * len(values) * numpy.log(2 * numpy.pi))
        w = numpy.outer(weights, weights) - scipy.linalg.cho_solve(
            (lower, True), numpy.eye(len(values)))
        correlation, slope = self.kernel(points, points, here)
        signal, noise = numpy.exp(2 * here[0]), numpy.exp(2 * here[-1])
        m = signal * w * slope
        by_lengths = ((points**2).T @ m.sum(1) - ((points.T @ m) * points.T).sum(1)) / numpy.exp(
            2 * here[1:-1])
        gradient = numpy.concatenate([
            [signal * ((w * correlation).sum() + self.NUGGET * numpy.trace(w))],
            by_lengths, [noise * numpy.trace(w)]])
        return cost, off / 3 - gradient

    def fit(self, points, values):
        found = scipy.optimize.minimize(
            self.negative_log_density, self.here, (points, values), "L-BFGS-B", jac=True,
            bounds=[(mean - 20, mean + 20) for mean in self.prior_mean],
            options={"maxiter": 50, "ftol": 1e-5})
        if numpy.isfinite(found.x).all():
            self.here = found.x

    def predict(self, points, values, at):
        """Mean and standard deviation at the rows of `at`."""
        while True:
            try:
                lower = self.factor(points, self.here)
                break
            except numpy.linalg.LinAlgError:  # ends: the noise grows
                self.here = self.here + numpy.log(10) * (numpy.arange(len(self.here)) ==
                                                         len(self.here) - 1)
        cross = numpy.exp(2 * self.here[0]) * self.kernel(points, at, self.here)[0]
        cross = scipy.linalg.solve_triangular(lower, cross, lower=True)
        whitened = scipy.linalg.solve_triangular(lower, values, lower=True)
        variance = numpy.exp(2 * self.here[0]) - (cross**2).sum(0)
        return cross.T @ whitened, numpy.sqrt(numpy.maximum(variance, 0))


def standardised(costs):
    """ln of the costs with mean 0 and deviation 1; without a cost, the largest so far."""
    values = numpy.log(numpy.maximum(costs, 1e-300))
    known = values[numpy.isfinite(values)]
    values[~numpy.isfinite(values)] = known.max() if len(known) else 0
    values -= values.mean()
    return values / (values.std() or 1)


def bayesian(embedding, box, bound, random, initial=10, noise=1e-3, ucb=False):
    """Bayesian optimisation of ln(cost) [Jones 1998] of x = BOUND clip(A y, +-1) in the box
    |y_i| <= box, with the settings of the code of [Nayebi 2019]: next is the best of 2,000 points of
    a Latin hypercube by the expected improvement, or by the upper confidence bound [Srinivas 2010]
    with the coefficient of the code of [Wang 2016]. Hyperparameters are fitted at every fifth point
    up to the 25th, then at every 20th."""
    dimension = embedding.shape[1]

    def hypercube(count):
        return 2 * scipy.stats.qmc.LatinHypercube(dimension, seed=random).random(count) - 1

    start = numpy.zeros(dimension + 2)
    start[-1] = 0.5 * numpy.log(noise)
    process = Process(ucb, start)
    points = numpy.vstack([numpy.zeros((1, dimension)), hypercube(initial - 1)])
    costs = []
    while True:
        n = len(costs)
        if n >= initial:
            candidates = hypercube(2000)
            values = standardised(numpy.array(costs))
            if (n - initial) % (5 if n <= 25 else 20) == 0:
                process.fit(points, values)
            mean, deviation = process.predict(points, values, candidates)
            if ucb:
                log = (0.5 * dimension + 2) * numpy.log(n) + numpy.log(numpy.pi**2 / 0.3)
                merits = deviation * numpy.sqrt(2 * log) - mean
            else:
                gain = values.min() - mean
                z = gain / numpy.maximum(deviation, 1e-300)
                merits = gain * scipy.special.ndtr(z) + deviation * scipy.stats.norm.pdf(z)
            points = numpy.vstack([points, candidates[numpy.argmax(merits)]])
        costs.append((yield bound * numpy.clip(box * embedding @ points[n], -1, 1)))


def make_search(method, size, bound, seed):
    random = numpy.random.default_rng(seed)
    if method == "cmaes":
        return cmaes(size, bound, random)
    if method == "bo":
        return bayesian(numpy.eye(size), 1, bound, random)
    family, d = method.rsplit("_", 1)
    d = int(d)
    if family == "hesbo":  # a count sketch: x_i = s_i y_h(i) [Nayebi 2019]
        embedding = numpy.zeros((size, d))
        embedding[range(size), random.integers(d, size=size)] = random.choice([-1, 1], size)
        return bayesian(embedding, 1, bound, random)
    embedding = random.standard_normal((size, d))  # [Wang 2016]
    if family == "rembo_ucb":
        box = max(1.5, 1.5 * numpy.log(d))
        return bayesian(embedding, box, bound, random, initial=1, noise=1e-6, ucb=True)
    return bayesian(embedding, numpy.sqrt(d), bound, random, noise=1e-6)  # [Nayebi 2019]


def main(method, size, bound, seed):
    search = make_search(method, int(size), float(bound), int(seed))
    point = next(search)
    begin = 0.0
    while True:
        end = time.process_time()
        print(end - begin, *map(repr, map(float, point)), flush=True)
        begin = end
        line = sys.stdin.readline()
        if not line:
            return
        try:
            point = search.send(numpy.inf if line.strip() == "none" else float(line))
        except StopIteration:
            return


if __name__ == "__main__":
    main(*sys.argv[1:])
