// SPDX-License-Identifier: Apache-2.0
#include "losses/readout/place_readouts.h"

#include <glog/logging.h>

#include <cmath>
#include <utility>

#include "physics/util/errors.h"
#include "physics/util/text_format.h"

namespace drape {
namespace {

using Eigen::Vector3d;

Vector3d MeanPlace(const Eigen::VectorXd& x, const std::vector<int>& vertices) {
  Vector3d mean = Vector3d::Zero();
  for (const int i : vertices) {
    CHECK(i >= 0 && 3 * i < x.size()) << i;
    mean += x.segment<3>(3 * i) / double(vertices.size());
  }
  return mean;
}

// The Jacobian of one number that depends on the mean of some vertices alone.
ReadoutJacobian ByVertices(const Vector3d& by_mean, const std::vector<int>& vertices,
                           Eigen::Index size) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const int i : vertices)
    for (int d = 0; d < 3; ++d)
      entries.emplace_back(0, 3 * i + d, by_mean[d] / double(vertices.size()));
  ReadoutJacobian jacobian(1, size);
  jacobian.setFromTriplets(entries.begin(), entries.end());
  return jacobian;
}

}  // namespace

bool PositionReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                           ReadoutJacobian* dr_dx) const {
  if (!x.allFinite()) return false;
  *r = x;
  if (dr_dx == nullptr) return true;
  dr_dx->resize(size_, size_);
  dr_dx->setIdentity();
  return true;
}

PlaceWeights WeightsOfPlaces(const Mesh& mesh, const Eigen::Matrix2Xd& material,
                             const std::string& where) {
  constexpr double kMostOutside = 0.1;  // of the height of a face
  PlaceWeights weights = InterpolationWeights(mesh, material, Extrapolation::kLinear);
  const Eigen::Vector2d low = mesh.uv.rowwise().minCoeff(), high = mesh.uv.rowwise().maxCoeff();
  for (int i = 0; i < weights.rows(); ++i)
    for (PlaceWeights::InnerIterator it(weights, i); it; ++it)
      if (!(it.value() >= -kMostOutside))
        throw InputError(
            where,
            Format("place %d at weft %g m, warp %g m is off the cloth, expected a "
                   "place on it (weft %g … %g m, warp %g … %g m)",
                   i + 1, material(0, i), material(1, i), low.x(), high.x(), low.y(), high.y()));
  return weights;
}

PlaceWeights WeightsOfVertices(const Mesh& mesh, const std::vector<int>& vertices,
                               const std::string& where) {
  PlaceWeights weights(static_cast<Eigen::Index>(vertices.size()), mesh.num_vertices());
  for (int i = 0; i < weights.rows(); ++i) {
    if (vertices[i] < 0 || vertices[i] >= mesh.num_vertices())
      throw InputError(where, Format("place %d is vertex %d, expected 0 … %d", i + 1, vertices[i],
                                     mesh.num_vertices() - 1));
    weights.insert(i, vertices[i]) = 1.0;
  }
  return weights;
}

MarkerReadout::MarkerReadout(const PlaceWeights& weights)
    : jacobian_(3 * weights.rows(), 3 * weights.cols()) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < weights.rows(); ++i)
    for (PlaceWeights::InnerIterator it(weights, i); it; ++it)
      for (int d = 0; d < 3; ++d) entries.emplace_back(3 * i + d, 3 * it.col() + d, it.value());
  jacobian_.setFromTriplets(entries.begin(), entries.end());
}

bool MarkerReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                         ReadoutJacobian* dr_dx) const {
  if (!x.allFinite()) return false;
  *r = jacobian_ * x;
  if (dr_dx != nullptr) *dr_dx = jacobian_;
  return true;
}

TipReadout::TipReadout(std::vector<int> tip, const Vector3d& along, double length)
    : tip_(std::move(tip)), along_(along), length_(length) {
  CHECK(!tip_.empty());
  CHECK_GT(length, 0.0);
}

bool TipReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r, ReadoutJacobian* dr_dx) const {
  const double far = along_.dot(MeanPlace(x, tip_)) / length_;
  r->setConstant(1, far);
  if (dr_dx != nullptr) *dr_dx = ByVertices(along_ / length_, tip_, x.size());
  return std::isfinite(far);
}

AngleReadout::AngleReadout(std::vector<int> tip, const Vector3d& clamp, const Vector3d& along)
    : tip_(std::move(tip)), clamp_(clamp), along_(along) {
  CHECK(!tip_.empty());
  CHECK_EQ(along.z(), 0.0);
}

bool AngleReadout::Read(const Eigen::VectorXd& x, Eigen::VectorXd* r,
                        ReadoutJacobian* dr_dx) const {
  constexpr double kDegree = M_PI / 180;
  const Vector3d chord = MeanPlace(x, tip_) - clamp_;
  const double reach = along_.dot(chord), drop = -chord.z();
  const double square = reach * reach + drop * drop;
  r->setConstant(1, std::atan2(drop, reach) / kDegree);
  const Vector3d by_tip = (-drop * along_ - reach * Vector3d::UnitZ()) / (square * kDegree);
  if (dr_dx != nullptr) *dr_dx = ByVertices(by_tip, tip_, x.size());
  return square > 0.0 && std::isfinite(square);
}

}  // namespace drape
