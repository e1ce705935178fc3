// SPDX-License-Identifier: Apache-2.0
#include "losses/outline/outline_match.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "losses/outline/outline.h"

namespace drape {
namespace {

using std::numbers::pi;

// The mirrored outline r(−θ).
Eigen::VectorXd Mirrored(const Eigen::VectorXd& outline) {
  Eigen::VectorXd result = outline;
  std::reverse(result.begin() + 1, result.end());
  return result;
}

double SquaredDistance(const Eigen::VectorXd& a, const Eigen::VectorXd& b, Eigen::Index shift) {
  const Eigen::Index rest = a.size() - shift;
  return (a.tail(rest) - b.head(rest)).squaredNorm() +
         (a.head(shift) - b.tail(shift)).squaredNorm();
}

}  // namespace

OutlineMatch MatchOutlines(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                           OutlineFreedom freedom) {
  OutlineMatch match{ProfileRms(a, b), 0.0, false};
  if (freedom == OutlineFreedom::kFixed) return match;
  const auto n = static_cast<double>(a.size());
  for (const bool mirrored : {false, true}) {
    if (mirrored && freedom != OutlineFreedom::kRotationAndMirror) break;
    const Eigen::VectorXd other = mirrored ? Mirrored(b) : b;
    for (Eigen::Index shift = 0; shift < a.size(); ++shift) {
      const double rms = std::sqrt(SquaredDistance(a, other, shift) / n);
      if (rms < match.rms) match = {rms, 2 * pi * static_cast<double>(shift) / n, mirrored};
    }
  }
  return match;
}

OutlineMatch RefineRotation(const Eigen::VectorXd& a, const Eigen::VectorXd& b,
                            OutlineMatch match) {
  CHECK_EQ(a.size(), b.size());
  CHECK_GE(a.size(), 3);
  const Eigen::VectorXd other = match.mirrored ? Mirrored(b) : b;
  const Eigen::Index n = a.size();
  const double spacing = 2 * pi / static_cast<double>(n);
  const auto shift = static_cast<Eigen::Index>(std::lround(match.rotation / spacing));
  const double before = SquaredDistance(a, other, (shift + n - 1) % n);
  const double best = SquaredDistance(a, other, shift % n);
  const double after = SquaredDistance(a, other, (shift + 1) % n);
  const double curvature = before - 2 * best + after;
  if (curvature > 0) match.rotation += spacing * 0.5 * (before - after) / curvature;
  return match;
}

}  // namespace drape
