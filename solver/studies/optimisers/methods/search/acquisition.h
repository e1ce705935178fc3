// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <random>

namespace drape {

// What a point promises, from the mean μ and the standard deviation σ of the posterior there; the
// largest is evaluated next.

// Expected improvement upon the least value f so far [Jones 1998, eq. 15]: (f − μ)·Φ(z) + σ·φ(z),
// z = (f − μ)/σ; max(f − μ, 0) where σ = 0.
double ExpectedImprovement(double mean, double deviation, double least);

// The upper confidence bound of −f after n evaluations in d dimensions [Srinivas 2010], with the
// coefficient of the code of [Wang 2016]: −μ + σ·√(2 ln(n^(d/2+2)·π²/0.3)).
double UpperConfidenceBound(double mean, double deviation, int evaluations, int dimension);

// A Latin hypercube in the box ±1, shape [dimension, count]: each coordinate has one point, at a
// random place, in each of `count` equal intervals.
Eigen::MatrixXd SampleLatinHypercube(int dimension, int count, std::mt19937_64& random);

}  // namespace drape
