// SPDX-License-Identifier: Apache-2.0
#include "solver/posterior/samples/elementwise_samples.h"

#include <glog/logging.h>

#include <utility>

#include "physics/util/math/random.h"

namespace drape {

ElementwiseSamples::ElementwiseSamples(Backend* backend, const MaterialField& base,
                                       const Scales& scales,
                                       const std::vector<SpecimenDrapes>& specimens,
                                       const OutlineResidualOptions& options, int draws,
                                       uint64_t seed, LostBranchPolicy policy)
    : ratio_(scales.element_sigma / scales.mean_sigma) {
  CHECK(!specimens.empty());
  for (std::size_t p = 0; p < specimens.size(); ++p)
    specimens_.push_back(HierarchicalSamples::Elementwise(backend, base, scales.mean_sigma,
                                                          specimens[p], options, draws,
                                                          SeedOfStream(seed, p), policy));
}

int ElementwiseSamples::num_residuals() const {
  int sum = 0;
  for (const auto& specimen : specimens_) sum += specimen->num_residuals();
  return sum;
}

Eigen::MatrixXd ElementwiseSamples::InUnitsOfMeans(Eigen::MatrixXd points) const {
  points.bottomRows(kMaterialEntries) *= ratio_;
  return points;
}

void ElementwiseSamples::Prepare(const Eigen::MatrixXd& points, bool with_jacobians) {
  const Eigen::MatrixXd scaled = InUnitsOfMeans(points);
  for (const auto& specimen : specimens_) specimen->Prepare(scaled, with_jacobians);
}

bool ElementwiseSamples::Residuals(int draw, Eigen::VectorXd* residual, RowMatrix* jacobian) const {
  residual->resize(num_residuals());
  if (jacobian != nullptr) jacobian->resize(num_residuals(), num_latents());
  Eigen::VectorXd part;
  RowMatrix part_jacobian;
  Eigen::Index row = 0;
  for (const auto& specimen : specimens_) {
    if (!specimen->Residuals(draw, &part, jacobian == nullptr ? nullptr : &part_jacobian))
      return false;
    residual->segment(row, part.size()) = part;
    if (jacobian != nullptr) jacobian->middleRows(row, part.size()) = part_jacobian;
    row += part.size();
  }
  if (jacobian != nullptr) jacobian->rightCols(kMaterialEntries) *= ratio_;
  return true;
}

bool ElementwiseSamples::StartAt(const Eigen::VectorXd& u) {
  const Eigen::VectorXd scaled = InUnitsOfMeans(u);
  for (const auto& specimen : specimens_)
    if (!specimen->StartAt(scaled)) return false;
  return true;
}

int ElementwiseSamples::num_extrapolated() const {
  int sum = 0;
  for (const auto& specimen : specimens_) sum += specimen->num_extrapolated();
  return sum;
}

RolloutCounts ElementwiseSamples::counts() const {
  RolloutCounts sum;
  for (const auto& specimen : specimens_) sum += specimen->counts();
  return sum;
}

}  // namespace drape
