// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/material/material.h"

namespace drape {

// One of the numbers by which a person compares two cloths.
struct StiffnessQuantity {
  const char* key;   // of JSON files, with the unit of the value
  const char* name;  // for a person
  const char* unit;  // in which a person reads scale·value
  double scale;
  double value;
};

// The means of the columns of stretch [N/m] and of the rows of bend [N·m] of one table of each kind
// [MODEL, M7, M8]; then the rigidity as drapes show it, also by weight [m³] and as a bending length
// [m]. weights: StiffnessWeights, shape [39].
std::vector<StiffnessQuantity> ListStiffness(const MaterialField& table,
                                             const Eigen::VectorXd& weights);

}  // namespace drape
