// SPDX-License-Identifier: Apache-2.0
#include "physics/cloth/contact/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/cloth/contact/barrier.h"

namespace drape {
namespace {

// Calls of(barrier, distance) for each obstacle within range of x.
template <class Of>
void ForEachNear(const Contact& contact, const Eigen::Vector3d& x, const Of& of) {
  for (const Obstacle& obstacle : contact.obstacles) {
    const ObstacleDistance distance = DistanceTo(obstacle, x);
    const double gap = distance.value - 0.5 * contact.thickness;
    if (gap < contact.range) of(EvaluateBarrier(gap, contact.range), distance);
  }
}

double Gap(const Contact& contact, const Obstacle& obstacle, const Eigen::Vector3d& x) {
  return DistanceTo(obstacle, x).value - 0.5 * contact.thickness;
}

// The share of the move dx from x that leaves a tenth of the gap. The distance from a convex solid
// is convex along a line, so its tangent is a lower bound, and Newton's method comes from the safe
// side. From any other it changes by no more than x does.
double SafeShare(const Contact& contact, const Obstacle& obstacle, const Eigen::Vector3d& x,
                 const Eigen::Vector3d& dx) {
  constexpr double kKept = 0.1, kEnough = 0.02;  // of the first gap
  constexpr int kMostSteps = 50;
  const bool is_convex = IsConvex(obstacle);
  double share = 0.0, kept = 0.0, enough = 0.0;
  for (int i = 0; i < kMostSteps; ++i) {
    const ObstacleDistance distance = DistanceTo(obstacle, x + share * dx);
    const double gap = distance.value - 0.5 * contact.thickness;
    if (i == 0) {
      kept = kKept * gap;
      enough = (kKept + kEnough) * gap;
    }
    const double approach = is_convex ? -distance.normal.dot(dx) : dx.norm();
    if (approach <= 0.0) return 1.0;
    if (gap <= enough) break;
    share += (gap - kept) / approach;
    if (share >= 1.0) return 1.0;
  }
  return share;
}

}  // namespace

PlateObstacle MakeSupport(const Contact& contact, double radius) {
  PlateObstacle plate;
  plate.radius = radius;
  plate.top.z() = -(0.5 * contact.thickness + 1.1 * contact.range);
  return plate;
}

double ContactEnergy(const Contact& contact, double area, const Eigen::Vector3d& x) {
  double energy = 0.0;
  ForEachNear(contact, x, [&](const Barrier& b, const ObstacleDistance&) {
    energy += contact.stiffness * area * b.value;
  });
  return energy;
}

Eigen::Vector3d ContactForce(const Contact& contact, double area, const Eigen::Vector3d& x) {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  ForEachNear(contact, x, [&](const Barrier& b, const ObstacleDistance& d) {
    force -= contact.stiffness * area * b.slope * d.normal;
  });
  return force;
}

Eigen::Matrix3d ContactStepStiffness(const Contact& contact, double area,
                                     const Eigen::Vector3d& x) {
  Eigen::Matrix3d stiffness = Eigen::Matrix3d::Zero();
  ForEachNear(contact, x, [&](const Barrier& b, const ObstacleDistance& d) {
    stiffness += contact.stiffness * area * b.curvature * d.normal * d.normal.transpose();
    // b' < 0. A convex solid has the other sign; that of a blend is the same in all directions.
    if (d.curvature.trace() < 0.0) stiffness += contact.stiffness * area * b.slope * d.curvature;
  });
  return stiffness;
}

Eigen::Matrix3d ContactStepDerivative(const Contact& contact, double area, const Eigen::Vector3d& x,
                                      const Eigen::Vector3d& w, double h) {
  Eigen::Matrix3d derivative = Eigen::Matrix3d::Zero();
  ForEachNear(contact, x, [&](const Barrier& b, const ObstacleDistance& d) {
    const Eigen::Matrix3d nn = d.normal * d.normal.transpose();
    const double speed = d.normal.dot(w);
    const Eigen::Matrix3d by_force = b.curvature * nn + b.slope * d.curvature;
    const Eigen::Matrix3d by_stiffness =
        b.third * speed * nn +
        b.curvature * (speed * d.curvature + d.normal * (d.curvature * w).transpose());
    derivative -= contact.stiffness * area * h * (by_force + h * by_stiffness);
  });
  return derivative;
}

double SmallestGap(const Contact& contact, const Eigen::VectorXd& x) {
  double smallest = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    for (const Obstacle& obstacle : contact.obstacles)
      smallest = std::min(smallest, Gap(contact, obstacle, x.segment<3>(i)));
  return smallest;
}

bool PushOut(const Contact& contact, Eigen::VectorXd& x) {
  constexpr double kLeast = 0.1, kNew = 0.5;  // gaps, of the range
  constexpr int kRounds = 10;                 // out of one obstacle can be into another
  bool moved = false;
  for (Eigen::Index i = 0; i < x.size(); i += 3)
    for (int round = 0, pushes = 1; round < kRounds && pushes > 0; ++round) {
      pushes = 0;
      for (const Obstacle& obstacle : contact.obstacles) {
        const ObstacleDistance distance = DistanceTo(obstacle, x.segment<3>(i));
        const double gap = distance.value - 0.5 * contact.thickness;
        if (gap >= kLeast * contact.range) continue;
        x.segment<3>(i) += (kNew * contact.range - gap) * distance.normal;
        ++pushes;
        moved = true;
      }
    }
  return moved;
}

void FollowObstacles(const Contact& contact, Eigen::VectorXd& x) {
  constexpr double kNear = 5e-3, kFar = 25e-3;  // [m]
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
    double share = 1.0;
    for (const Obstacle& obstacle : contact.obstacles)
      share = std::min(share, SafeShare(contact, obstacle, x.segment<3>(i), dx.segment<3>(i)));
    if (share == 1.0) continue;
    dx.segment<3>(i) *= share;
    shortened = true;
  }
  return shortened;
}

}  // namespace drape
