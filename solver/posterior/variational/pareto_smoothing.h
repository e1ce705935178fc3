// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace drape {

// How heavy the tail of importance weights is [Vehtari 2024]: the
// shape k̂ of a generalised Pareto distribution fitted to the largest min(N/5, 3√N) weights by the
// estimate of [Zhang 2009], drawn towards ½ as there. Below 0.7 estimates by these
// weights can be trusted; above, the distribution that was drawn from is too far from the other.
// log_weights: of N ≥ 25 draws, finite, shape [N]. 0 when all are equal, infinite when fewer than 5
// are above the tail threshold.
double ParetoShape(const Eigen::VectorXd& log_weights);

}  // namespace drape
