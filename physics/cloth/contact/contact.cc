// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/contact.h"

#include <algorithm>
#include <limits>

#include "physics/cloth/contact/vertex_contact.h"

namespace drape {
namespace {

// What the formulas of vertex_contact.h take.
struct PlainContact {
  explicit PlainContact(const Contact& contact)
      : thickness(2.0 * contact.offset()),
        range(contact.range),
        stiffness(contact.stiffness),
        count(static_cast<int>(contact.obstacles.size())),
        obstacles(contact.obstacles) {}

  SolidDistance Distance(int k, const Vec3<double>& x) const {
    return DistanceTo(MakeSolid(obstacles[k]), x);
  }
  bool IsConvex(int k) const { return drape::IsConvex(MakeSolid(obstacles[k])); }
  void AddBlendChange(int k, const Vec3<double>& x, const Vec3<double>& w, double scale,
                      double (&block)[9]) const {
    drape::AddBlendChange(MakeSolid(obstacles[k]).surface, x, w, scale, block);
  }

  double thickness, range, stiffness;
  int count;
  const std::vector<Obstacle>& obstacles;
};

Eigen::Matrix3d InEigen(const double (&block)[9]) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(block);
}

double Gap(const Contact& contact, const Obstacle& obstacle, const Eigen::Vector3d& x) {
  return DistanceTo(obstacle, x).value - contact.offset();
}

}  // namespace

double ContactEnergy(const Contact& contact, double area, const Eigen::Vector3d& x) {
  return VertexEnergy(PlainContact(contact), area, Plain(x));
}

Eigen::Vector3d ContactForce(const Contact& contact, double area, const Eigen::Vector3d& x) {
  const Vec3<double> force = VertexForce(PlainContact(contact), area, Plain(x));
  return {force.x, force.y, force.z};
}

Eigen::Matrix3d ContactStepStiffness(const Contact& contact, double area,
                                     const Eigen::Vector3d& x) {
  double block[9] = {};
  AddVertexStepStiffness(PlainContact(contact), area, Plain(x), 1.0, block);
  return InEigen(block);
}

Eigen::Matrix3d ContactStepDerivative(const Contact& contact, double area, const Eigen::Vector3d& x,
                                      const Eigen::Vector3d& w, double h) {
  double block[9] = {};
  AddVertexStepDerivative(PlainContact(contact), area, Plain(x), Plain(w), h, block);
  return InEigen(block);
}

double SmallestGap(const Contact& contact, const Eigen::VectorXd& x) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    for (const Obstacle& obstacle : contact.obstacles)
      smallest = std::min(smallest, Gap(contact, obstacle, x.segment<3>(i)));
  return smallest;
}

bool PushOut(const Contact& contact, Eigen::VectorXd& x, int threads) {
  bool moved = false;
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads) if (threads > 1) \
    reduction(||                                                                     \
              : moved)
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    Vec3<double> place = Plain(x.segment<3>(i));
    if (!PushVertexOut(PlainContact(contact), place)) continue;
    x.segment<3>(i) << place.x, place.y, place.z;
    moved = true;
  }
  return moved;
}

void FollowObstacles(const Contact& contact, Eigen::VectorXd& x, int threads) {
  constexpr double kNear = 5e-3, kFar = 25e-3;  // [m]
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads) if (threads > 1)
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    for (const Obstacle& obstacle : contact.obstacles) {
      const Eigen::Vector3d place = x.segment<3>(i);
      const double gap = Gap(contact, obstacle, place);
      if (gap < kFar)
        x.segment<3>(i) +=
            std::min(1.0, (kFar - gap) / (kFar - kNear)) * SurfaceMove(obstacle, place);
    }
}

bool ShortenMoves(const Contact& contact, const Eigen::VectorXd& x, Eigen::VectorXd& dx) {
  bool shortened = false;
  for (Eigen::Index i = 0; i < x.size(); i += 3) {
    const double share =
        SafeShare(PlainContact(contact), Plain(x.segment<3>(i)), Plain(dx.segment<3>(i)));
    if (share == 1.0) continue;
    dx.segment<3>(i) *= share;
    shortened = true;
  }
  return shortened;
}

Clearance::Clearance(const Contact& contact, const Eigen::VectorXd& x, int threads)
    : contact_(&contact), threads_(threads), x_(x), gap_(x.size() / 3) {
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads_) if (threads_ > 1)
  for (Eigen::Index i = 0; i < gap_.size(); ++i)
    gap_[i] = SmallestGap(contact, x.segment<3>(3 * i));
}

bool Clearance::MayTouch(int i, const Eigen::Vector3d& place) const {
  return gap_[i] - (place - x_.segment<3>(3 * i)).norm() < contact_->range;
}

bool Clearance::ShortenMoves(const Eigen::VectorXd& x, Eigen::VectorXd& dx) const {
  bool shortened = false;
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads_) if (threads_ > 1) \
    reduction(||                                                                       \
              : shortened)
  for (int i = 0; i < static_cast<int>(gap_.size()); ++i) {
    const double way = (x.segment<3>(3 * i) - x_.segment<3>(3 * i)).norm();
    // More is left of the gap after the move than where a move is shortened.
    if (gap_[i] - way - dx.segment<3>(3 * i).norm() > 0.15 * (gap_[i] + way)) continue;
    Eigen::VectorXd move = dx.segment<3>(3 * i);
    if (!drape::ShortenMoves(*contact_, x.segment<3>(3 * i), move)) continue;
    dx.segment<3>(3 * i) = move;
    shortened = true;
  }
  return shortened;
}

}  // namespace drape
