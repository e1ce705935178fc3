// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace drape {

// What may be done to the second outline before it is compared.
enum class OutlineFreedom { kFixed, kRotation, kRotationAndMirror };

struct OutlineMatch {
  double rms = 0.0;       // least root mean square difference, in the outlines' unit
  double rotation = 0.0;  // of b, counter-clockwise, a multiple of 2π/n [rad]
  bool mirrored = false;  // b(−θ) before the rotation
};
// a, b: equal, non-zero sizes n.
OutlineMatch MatchOutlines(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                           OutlineFreedom freedom = OutlineFreedom::kFixed);

// The match with its rotation between the angles: the least of the parabola through the squared
// differences at the best multiple of 2π/n and its two neighbours; rms stays the sampled one. n
// ≥ 3.
OutlineMatch RefineRotation(const Eigen::VectorXd& a, const Eigen::VectorXd& b, OutlineMatch match);

}  // namespace drape
