// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace drape {

// The motions allowed for the second outline before the comparison.
enum class OutlineFreedom { kFixed, kRotation, kRotationAndMirror };

struct OutlineMatch {
  double rms = 0.0;       // smallest root mean square difference, in the unit of the outlines
  double rotation = 0.0;  // of b, counter-clockwise, a multiple of 2π/n [rad]
  bool mirrored = false;  // b(−θ) before the rotation
};
// Finds the motion of b with the smallest root mean square difference to a [MODEL, M50]. Both have
// the same non-zero size n.
OutlineMatch MatchOutlines(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                           OutlineFreedom freedom = OutlineFreedom::kFixed);

// Returns the match with its rotation refined between the angles: the minimum of the parabola
// through the squared differences at the best multiple of 2π/n and its two neighbours. rms remains
// the sampled one. n ≥ 3.
OutlineMatch RefineRotation(const Eigen::VectorXd& a, const Eigen::VectorXd& b, OutlineMatch match);

}  // namespace drape
