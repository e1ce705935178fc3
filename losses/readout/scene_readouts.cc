// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/scene_readouts.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "physics/cloth/assembly/dynamics.h"
#include "physics/simulation/statics/stiffness.h"

namespace drape {

HandleForceReadout::HandleForceReadout(const ClothModel& model, const std::vector<int>& vertices,
                                       const Eigen::Matrix3Xd& axes)
    : jacobian_(axes.cols(), model.num_dofs()) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const int i : vertices) {
    CHECK(std::binary_search(model.held.begin(), model.held.end(), i)) << i;
    for (int k = 0; k < axes.cols(); ++k)
      for (int d = 0; d < 3; ++d)
        entries.emplace_back(k, 3 * i + d, -model.scene.handles->stiffness * axes(d, k));
  }
  jacobian_.setFromTriplets(entries.begin(), entries.end());
  at_zero_ = -jacobian_ * model.mesh.rest_x;
}

bool HandleForceReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                              ReadoutJacobian* dr_dx) const {
  *r = at_zero_ + jacobian_ * x;
  if (dr_dx != nullptr) *dr_dx = jacobian_;
  return r->allFinite();
}

FrequencyReadout::FrequencyReadout(const ClothModel& model, std::vector<int> modes)
    : solver_(std::shared_ptr<const ClothModel>(std::shared_ptr<void>(), &model)),
      modes_(std::move(modes)) {
  CHECK(!modes_.empty());
}

bool FrequencyReadout::ReadCloth(const MaterialField& material, const Eigen::VectorXd& x,
                                 Eigen::VectorXd* r, ReadoutJacobian* dr_dx,
                                 MaterialJacobian* dr_dp) const {
  StepSolver solver = solver_.Clone();
  const VibrationModes lowest =
      LowestModes(solver, material, x, *std::max_element(modes_.begin(), modes_.end()));
  if (lowest.eigenvalues.size() == 0) return false;
  r->resize(size());
  RowMatrix by_x(size(), x.size());
  if (dr_dp != nullptr) dr_dp->setZero(size(), kMaterialEntries + kDynamicsEntries);
  for (int k = 0; k < size(); ++k) {
    const double square = lowest.eigenvalues[modes_[k] - 1];
    (*r)[k] = std::copysign(std::sqrt(std::abs(square)), square) / (2.0 * M_PI);
    if (dr_dx == nullptr && dr_dp == nullptr) continue;
    const EigenvalueGradient gradient =
        DeriveEigenvalue(solver, material, x, lowest.shapes.col(modes_[k] - 1));
    const double by_square = 1.0 / (8.0 * M_PI * M_PI * std::abs((*r)[k]));
    by_x.row(k) = by_square * gradient.by_x.transpose();
    if (dr_dp == nullptr) continue;
    dr_dp->row(k).head<kMaterialEntries>() =
        by_square * gradient.by_material.Contract(material).transpose();
    (*dr_dp)(k, kMaterialEntries + kByDensity) = -by_square * square / material.density;
  }
  if (dr_dx != nullptr) *dr_dx = by_x.sparseView();
  return r->allFinite();
}

}  // namespace drape
