// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/garment/body/limbs.h"

#include <algorithm>
#include <cmath>

#include "physics/util/text_format.h"
#include "solver/prediction/garment/body/wrap.h"

namespace drape {
namespace {

using Eigen::Vector3d;

Vector3d Across(const Vector3d& p) { return {p.x(), 0, p.z()}; }

// Where arms and legs are and bend, in heights of the person.
struct LimbPlace {
  double joint_side, joint_up;          // as ours
  double least_side, most_side, above;  // of hand or foot
  double bend;                          // the length over which it bends
  double inner;                         // no cloth around it comes nearer to the middle
};
constexpr LimbPlace kLimbPlaces[2] = {{.098, .802, .12, .6, .38, .05, .115},
                                      {.055, .480, .00, .2, .00, .10, .0}};
constexpr double kWidth = .03;  // of the slices of which middles are taken [m]

}  // namespace

Limbs::Limbs(const ObjSurface& person)
    : thin_(person.x),
      share_(Eigen::VectorXd::Zero(person.x.size() / 3)),
      limb_of_(person.x.size() / 3, 0) {
  constexpr double kShare = .75, kHips = .5, kChest = .65;  // of the way; of the height
  constexpr double kThick = .05;  // of a limb that is drawn together, in heights
  const Eigen::VectorXd &x = person.x, contracted = Contract(person, kLimb);
  const auto heights = x.reshaped(3, x.size() / 3).row(2);
  low_ = heights.minCoeff();
  height_ = heights.maxCoeff() - low_;
  for (int k = 0; k < 4; ++k) {
    Limb& limb = limbs_[k];
    const LimbPlace& place = kLimbPlaces[k / 2];
    const int side = k % 2 == 0 ? 1 : -1;
    limb.joint = {side * place.joint_side * height_, 0, low_ + place.joint_up * height_};
    Vector3d tip = limb.joint;
    for (int i = 0; i < share_.size(); ++i) {
      const Vector3d p = Vertex(x, i);
      if (side * p.x() >= place.least_side * height_ && side * p.x() <= place.most_side * height_ &&
          p.z() >= low_ + place.above * height_ && (k < 2 || p.z() < limb.joint.z()) &&
          Across(p - limb.joint).norm() > Across(tip - limb.joint).norm())
        tip = p;
    }
    const double length = Across(tip - limb.joint).norm();
    if (length < 3 * kThick * height_) continue;
    limb.length = length;
    limb.along = Across(tip - limb.joint) / length;
    for (int i = 0; i < share_.size(); ++i) {
      const Vector3d p = Across(Vertex(contracted, i) - limb.joint);
      const double far = p.dot(limb.along), off = (p - far * limb.along).norm() / height_;
      const double share =
          SmoothStep(far / (place.bend * height_)) * (1 - SmoothStep((off - kThick / 2) / kThick));
      if (share <= share_[i]) continue;
      share_[i] = share;
      limb_of_[i] = k;
    }
  }
  for (int i = 0; i < share_.size(); ++i) {
    Vector3d way = kShare * (Vertex(contracted, i) - Vertex(x, i));
    const double above = SmoothStep(((x[3 * i + 2] - low_) / height_ - kHips) / (kChest - kHips));
    way.z() *= limb_of_[i] < 2 ? std::max(above, share_[i]) : above;
    thin_.segment<3>(3 * i) += way;
  }
  for (const Limb& limb : limbs_) DrawIn(limb);
}

void Limbs::TurnArms(double angle) {
  for (int k = 0; k < 2; ++k) {
    const int side = k == 0 ? 1 : -1;
    Limb& arm = limbs_[k];
    const double now = std::atan2(side * arm.along.x(), -arm.along.z());
    if (arm.length > 0) arm.turn = Eigen::AngleAxisd(side * (now - angle), Vector3d::UnitY());
  }
}

std::string Limbs::ReachInto(const ClothTube& tube) {
  constexpr double kShoulders = .6;  // of the height
  if (tube.empty()) return "";
  const bool is_leg = tube.back().middle.z() < low_ + kShoulders * height_;
  const bool is_right = tube.back().middle.x() < 0;
  Limb& limb = limbs_[2 * is_leg + is_right];
  if (limb.length == 0) return "";
  std::vector<double> far;
  std::vector<Vector3d> middles, rings;  // off the joint
  for (const ClothRing& ring : tube) {
    const double at = (ring.middle - limb.joint).norm();
    if (ring.inner < kLimbPlaces[is_leg].inner * height_ || at > limb.length - kWidth) continue;
    far.push_back(at);
    middles.push_back(Middle(limb, at) - limb.joint);
    rings.push_back(ring.middle - limb.joint);
  }
  if (far.empty()) return "";
  // The turn leads to the cuff, and the shift to the rings between.
  const size_t cuff = std::max_element(far.begin(), far.end()) - far.begin();
  limb.turn = Eigen::AngleAxisd(Eigen::Quaterniond::FromTwoVectors(limb.along, rings[cuff]));
  limb.to = far[cuff];
  const auto count = static_cast<Eigen::Index>(far.size());
  const Eigen::Map<const Eigen::VectorXd> s(far.data(), count);
  const Eigen::Map<const Eigen::Matrix3Xd> of_limb(middles[0].data(), 3, count),
      of_cloth(rings[0].data(), 3, count);
  const Eigen::Matrix3Xd off = of_cloth - limb.turn.toRotationMatrix() * of_limb;
  Eigen::MatrixXd powers(count, 3);
  powers << s, s.array().pow(2), s.array().pow(3);
  const auto weights = s.asDiagonal();  // tubes narrow towards their cuffs
  const Eigen::Index used = std::min<Eigen::Index>(3, (count + 1) / 2);
  limb.bend.setZero();
  limb.bend.leftCols(used) = (weights * powers.leftCols(used))
                                 .colPivHouseholderQr()
                                 .solve(weights * off.transpose())
                                 .transpose();
  return Format("%s %s turned by %.0f degrees and moved by %.1f cm", is_right ? "right" : "left",
                is_leg ? "leg" : "arm", limb.turn.angle() * 180 / M_PI,
                100 * off.colwise().norm().maxCoeff());
}

void Limbs::Move(double share, Eigen::VectorXd& x) const {
  for (int i = 0; i < share_.size(); ++i) {
    const Limb& limb = limbs_[limb_of_[i]];
    const double part = share * share_[i];
    const Eigen::AngleAxisd turn(part * limb.turn.angle(), limb.turn.axis());
    const double far = std::min(limb.to, (Vertex(thin_, i) - limb.joint).norm());
    const Vector3d shift = limb.bend * Vector3d(far, far * far, far * far * far);
    x.segment<3>(3 * i) = limb.joint + part * shift + turn * (Vertex(x, i) - limb.joint);
  }
}

// Draws a limb half of the way to the line of its middles, hand or foot as well.
void Limbs::DrawIn(const Limb& limb) {
  constexpr double kPart = .5;
  std::vector<Vector3d> line;
  for (double far = 0; far < limb.length - kWidth; far += kWidth) line.push_back(Middle(limb, far));
  for (int i = 0; i < share_.size() && line.size() > 1; ++i) {
    if (&limbs_[limb_of_[i]] != &limb) continue;
    const double at = (Vertex(thin_, i) - limb.joint).norm() / kWidth;
    const size_t k = std::min(static_cast<size_t>(at), line.size() - 2);
    const Vector3d along = (line[k + 1] - line[k]).normalized(), off = Vertex(thin_, i) - line[k];
    thin_.segment<3>(3 * i) -= kPart * share_[i] * (off - off.dot(along) * along);
  }
}

// The middle of a limb, so far from its joint [m].
Vector3d Limbs::Middle(const Limb& limb, double far) const {
  Vector3d sum = Vector3d::Zero();
  double weights = 0;
  for (int i = 0; i < share_.size(); ++i) {
    if (&limbs_[limb_of_[i]] != &limb || share_[i] == 0) continue;
    const double apart = ((Vertex(thin_, i) - limb.joint).norm() - far) / kWidth;
    const double weight = share_[i] * std::exp(-apart * apart);
    sum += weight * Vertex(thin_, i);
    weights += weight;
  }
  return sum / weights;
}

}  // namespace drape
