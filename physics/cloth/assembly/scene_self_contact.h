// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "physics/cloth/cloth_model.h"
#include "physics/cloth/contact/surface_contact.h"

namespace drape {

// Contact of the cloth with itself as a scene has it [MODEL, M62].

bool HasSelfContact(const Scene& scene);
// CHECKs that the scene has it.
SurfaceContact MakeSelfContact(const ClothModel& model);
// Throws InputError where thickness and range together are more than the mean edge: neighbours
// would touch. Nothing where the scene has no such contact.
void RequireThinCloth(const ClothModel& model);

// Where a cloth overlaps itself: two faces meet, by exact predicates, or two parts are not further
// apart than the cloth is thick.
struct SelfOverlap {
  std::array<int, 2> vertex;  // one of each part
  double distance = 0.0;      // of the parts, 0 where faces meet [m]
};
// The first; none where the scene has no such contact.
std::optional<SelfOverlap> FindSelfOverlap(const ClothModel& model, const Eigen::VectorXd& x);

// The smallest gap of the pairs that push [m]; the range of the contact if no pair does.
double SmallestSelfGap(const ClothModel& model, const Eigen::VectorXd& x);

// `to`, or as much of the way there as no part of the cloth passes through another: shapes that are
// extrapolated can overlap. The shape `from` does not.
Eigen::VectorXd ReachSafely(const ClothModel& model, const Eigen::VectorXd& from,
                            const Eigen::VectorXd& to);

}  // namespace drape
