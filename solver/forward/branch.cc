// SPDX-License-Identifier: Apache-2.0
#include "solver/forward/branch.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "losses/outline/outline.h"
#include "losses/outline/shape_features.h"

namespace drape {
namespace {

using std::numbers::pi;

StartShape::Mode ModeOfOutline(const Eigen::VectorXd& outline, int k) {
  const double n = static_cast<double>(outline.size());
  double a = 0.0, b = 0.0;
  for (Eigen::Index i = 0; i < outline.size(); ++i) {
    const double angle = 2 * pi * k * static_cast<double>(i) / n;
    a += 2 * outline[i] * std::cos(angle) / n;
    b += 2 * outline[i] * std::sin(angle) / n;
  }
  return {k, std::hypot(a, b), std::atan2(b, a)};
}

}  // namespace

bool DrapeOutline(const Mesh& mesh, const Eigen::VectorXd& x, Eigen::VectorXd* outline) {
  const Camera camera;
  Outline seen;
  if (!OutlineFromMesh(mesh, x, camera, kBranchAngles, &seen)) return false;
  *outline = MetresFromPixels(seen.radius, camera);
  return true;
}

BranchSignature ComputeSignature(const Eigen::VectorXd& outline, const DrapeDiscs& discs,
                                 const SignatureOptions& options) {
  CHECK_GT(outline.size(), 2 * options.range.last);
  CHECK_GE(outline.size(), 180);
  CHECK(options.modes >= 1 && options.range.first >= 1);
  CHECK_GE(options.range.last, options.range.first);
  BranchSignature signature;
  signature.folds = CountFolds(outline);
  signature.drape_coefficient = DrapeCoefficient(ProfileArea(outline), discs);
  for (int k = options.range.first; k <= options.range.last; ++k) {
    signature.modes.push_back(ModeOfOutline(outline, k));
  }
  std::sort(signature.modes.begin(), signature.modes.end(),
            [](const auto& a, const auto& b) { return a.amplitude_m > b.amplitude_m; });
  if (signature.modes.size() > static_cast<size_t>(options.modes)) {
    signature.modes.resize(options.modes);
  }
  return signature;
}

double VertexDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  CHECK_EQ(a.size(), b.size());
  CHECK_GT(a.size(), 0);
  return (a - b).norm() / std::sqrt(static_cast<double>(a.size()) / 3.0);
}

std::vector<std::vector<int>> ClusterByDistance(const Eigen::MatrixXd& distance, double tolerance) {
  CHECK_EQ(distance.rows(), distance.cols());
  const int n = static_cast<int>(distance.rows());
  std::vector<bool> taken(n, false);
  std::vector<std::vector<int>> clusters;
  for (int first = 0; first < n; ++first) {
    if (taken[first]) continue;
    std::vector<int> members = {first};
    taken[first] = true;
    for (size_t next = 0; next < members.size(); ++next) {
      for (int other = 0; other < n; ++other) {
        if (taken[other] || distance(members[next], other) > tolerance) continue;
        taken[other] = true;
        members.push_back(other);
      }
    }
    std::sort(members.begin(), members.end());
    clusters.push_back(std::move(members));
  }
  return clusters;
}

}  // namespace drape
