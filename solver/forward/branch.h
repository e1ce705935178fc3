// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "losses/outline/measured_image.h"
#include "physics/cloth/start_shape.h"
#include "physics/mesh/disc.h"

namespace drape {

// Which of a cloth's many stable drapes one is [METHODS, P13]: what tells two apart,
// and how far apart they are.

inline constexpr int kBranchAngles = 360;

struct BranchSignature {
  int folds = 0;
  double drape_coefficient = 0.0;
  // Strongest waves of the hem's outline, amplitude·cos(k·θ − phase) [m], the largest first.
  std::vector<StartShape::Mode> modes;
};

struct SignatureOptions {
  ModeRange range = {2, 15};  // waves that are looked at
  int modes = 3;              // that are kept, ≥ 1
};

// Outline r(θ_i) of the hem seen from above [m], θ_i = 2π i/kBranchAngles, shape [kBranchAngles].
// False when a ray meets no cloth or x is not finite. x: [m], shape [3V].
bool DrapeOutline(const Mesh& mesh, const Eigen::VectorXd& x, Eigen::VectorXd* outline);

// Of an outline [m], shape [n] at θ_i = 2π i/n. CHECKs n > 2·range.last, n ≥ 180.
BranchSignature ComputeSignature(const Eigen::VectorXd& outline, const DrapeDiscs& discs,
                                 const SignatureOptions& options = {});

// Root mean square distance of equal vertices [m]; a, b: [3V]. It is 0 on one branch only: turned
// and mirrored drapes are others.
double VertexDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

// Groups of items that a chain of distances ≤ tolerance links (single linkage), each ascending, in
// the order of their first members. distance: symmetric, shape [n, n].
std::vector<std::vector<int>> ClusterByDistance(const Eigen::MatrixXd& distance, double tolerance);

}  // namespace drape
