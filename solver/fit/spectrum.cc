// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/spectrum.h"

#include <Eigen/SVD>

namespace drape {

Spectrum ComputeSpectrum(const Eigen::MatrixXd& jacobian, double prior_sigma) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian, Eigen::ComputeFullV);
  Spectrum spectrum;
  spectrum.values = Eigen::VectorXd::Zero(jacobian.cols());
  spectrum.values.head(svd.singularValues().size()) = svd.singularValues();
  spectrum.directions = svd.matrixV();
  spectrum.determined = static_cast<int>((spectrum.values.array() * prior_sigma > 1.0).count());
  return spectrum;
}

}  // namespace drape
