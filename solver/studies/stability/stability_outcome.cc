// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/stability_outcome.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/material/laws/hinge_geometry.h"
#include "solver/forward/random_drapes.h"

namespace drape {
namespace {

// A triangle of the support whose normal points down.
bool LiesFaceDown(const ClothModel& model, const Eigen::VectorXd& x) {
  std::vector<char> is_held(model.mesh.num_vertices());
  for (const int i : model.held) is_held[i] = true;
  const auto at = [&](int i) -> Eigen::Vector3d { return x.segment<3>(3 * i); };
  return std::any_of(model.mesh.faces.begin(), model.mesh.faces.end(), [&](const Face& face) {
    const int* v = face.vertex;
    if (!is_held[v[0]] || !is_held[v[1]] || !is_held[v[2]]) return false;
    return (at(v[1]) - at(v[0])).cross(at(v[2]) - at(v[0])).z() < 0.0;
  });
}

bool IsCreased(const Mesh& mesh, const Eigen::VectorXd& x, double fold) {
  return std::any_of(mesh.hinges.begin(), mesh.hinges.end(), [&](const Hinge& hinge) {
    return std::abs(DihedralAngle(GatherCorners(hinge, x.data()))) > fold;
  });
}

}  // namespace

bool IsLost(const Eigen::VectorXd& x, const StabilityRules& rules) {
  return !x.allFinite() || x.cwiseAbs().maxCoeff() > rules.far;
}

bool IsFoldedOver(const ClothModel& model, const Eigen::VectorXd& x, const StabilityRules& rules) {
  double highest = x[2];
  for (int i = 0; i < model.mesh.num_vertices(); ++i) highest = std::max(highest, x[3 * i + 2]);
  return highest > rules.above || LiesFaceDown(model, x) || IsCreased(model.mesh, x, rules.fold);
}

StabilityOutcome Classify(const ClothModel& model, const StabilityEnd& end,
                          const Eigen::VectorXd& reference, const RestOf& rest,
                          const StabilityRules& rules) {
  if (end.status == IntegratorStatus::kNotFinite || IsLost(end.x, rules))
    return StabilityOutcome::kDiverged;
  if (end.status == IntegratorStatus::kNotPositiveDefinite) return StabilityOutcome::kFactorFailed;
  if (end.status == IntegratorStatus::kNotConverged) return StabilityOutcome::kNotConverged;
  if (IsFoldedOver(model, end.x, rules)) return StabilityOutcome::kFoldedOver;
  if (!(end.speed <= rules.speed)) return StabilityOutcome::kStillMoving;
  const auto is_reference = [&](const Eigen::VectorXd& x) {
    return reference.size() == 0 || VertexDistance(x, reference) <= rules.branch;
  };
  if (is_reference(end.x)) return StabilityOutcome::kSettled;
  const std::optional<Eigen::VectorXd> leads_to = rest(end.x);
  return leads_to && is_reference(*leads_to) ? StabilityOutcome::kStillMoving
                                             : StabilityOutcome::kOtherBranch;
}

}  // namespace drape
