// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace drape {

// Which combinations of the parameters the data determine: the singular values of the Jacobian of
// the (whitened) residuals. Along right singular vector i the data alone know θ to 1/value[i];
// where that is better than the prior's σ the direction is determined by the data.
struct Spectrum {
  Eigen::VectorXd values;      // descending, shape [P]; of K < P residuals the last are 0
  Eigen::MatrixXd directions;  // columns, shape [P, P]
  int determined = 0;          // values · prior_sigma > 1
};

// jacobian: ∂residual/∂θ, shape [K, P].
Spectrum ComputeSpectrum(const Eigen::MatrixXd& jacobian, double prior_sigma);

}  // namespace drape
