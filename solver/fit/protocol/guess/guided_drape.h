// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solver/fit/observation.h"
#include "solver/forward/settle.h"

namespace drape {

// Of the many drapes of a material, one near an image [METHODS, P58]: while the cloth falls, the
// part that overhangs is pulled towards the outline of the image, then released.

// The pull of an outline on a cloth. References outlive the object.
class OutlinePull {
 public:
  OutlinePull(const ClothModel& model, const Observation& observation);

  // How far each vertex is to be displaced for the outline of x to be the image's [m], shape [3V]:
  // that of the hem along the normal of its outline, of the cloth between hem and support in
  // proportion to the distance from the support. Zero where the hem is hidden, and without a closed
  // outline.
  Eigen::VectorXd Displacement(const Eigen::VectorXd& x) const;

 private:
  Eigen::Matrix3Xd HemDisplacement(const Eigen::VectorXd& x) const;  // [hem]

  // Where a vertex lies between support and hem, and between two vertices of the hem by its angle.
  struct Place {
    double from_support = 0.0;  // 0 on the support … 1 on the hem
    int before = 0, next = 0;   // of the hem
    double to_next = 0.0;       // 0 … 1
  };

  const ClothModel& model_;
  const Observation& observation_;
  std::vector<int> hem_;
  std::vector<Place> places_;  // [V]
};

// Settles a start under a material as Settle does, with the first of options.steps under the pull.
SettledDrape SettleGuided(Backend& backend, const MaterialField& material, const State& start,
                          const Observation& observation, const SettleOptions& options);

}  // namespace drape
