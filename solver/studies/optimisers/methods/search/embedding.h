// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <random>

namespace drape {

// A box of few numbers in which a box of many is searched: x = clip(A·y, ±1), |y_i| ≤ box.
struct Embedding {
  Eigen::MatrixXd matrix;  // A, shape [D, d]
  double box = 1.0;

  int dimension() const { return static_cast<int>(matrix.cols()); }  // d
  // x, shape [D], of y, shape [d].
  Eigen::VectorXd Map(const Eigen::VectorXd& y) const;
};

// x = y.
Embedding MakeIdentityEmbedding(int size);
// REMBO [Wang 2016]: entries of A are standard normal, box = √d as in the code of [Nayebi 2019].
Embedding MakeGaussianEmbedding(int size, int dimension, std::mt19937_64& random);
// HeSBO [Nayebi 2019], a count sketch: x_i = s_i·y_h(i), with h uniform in 1 … d and the signs s
// uniform. Box 1, so that nothing is ever clipped.
Embedding MakeHashingEmbedding(int size, int dimension, std::mt19937_64& random);

}  // namespace drape
