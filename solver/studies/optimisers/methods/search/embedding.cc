// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/optimisers/methods/search/embedding.h"

#include <glog/logging.h>

#include <cmath>

#include "physics/util/math/random.h"

namespace drape {

Eigen::VectorXd Embedding::Map(const Eigen::VectorXd& y) const {
  CHECK_EQ(y.size(), matrix.cols());
  return (matrix * y).cwiseMax(-1.0).cwiseMin(1.0);
}

Embedding MakeIdentityEmbedding(int size) { return {Eigen::MatrixXd::Identity(size, size), 1.0}; }

Embedding MakeGaussianEmbedding(int size, int dimension, std::mt19937_64& random) {
  Embedding embedding{Eigen::MatrixXd(size, dimension), std::sqrt(static_cast<double>(dimension))};
  for (double& entry : embedding.matrix.reshaped()) entry = SampleNormal(random);
  return embedding;
}

Embedding MakeHashingEmbedding(int size, int dimension, std::mt19937_64& random) {
  Embedding embedding{Eigen::MatrixXd::Zero(size, dimension), 1.0};
  for (int i = 0; i < size; ++i) {
    const int column = static_cast<int>(SampleUniform(random) * dimension);
    embedding.matrix(i, column) = SampleUniform(random) < 0.5 ? -1.0 : 1.0;
  }
  return embedding;
}

}  // namespace drape
