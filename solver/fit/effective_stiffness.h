// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "physics/cloth/cloth_model.h"
#include "physics/material/material.h"

namespace drape {

// The stiffness with which drapes resist [METHODS, P59]: means of the entries of a table, weighted
// by the energy that each has at these drapes. An entry of strains and curvatures that no drape
// reaches, which no outline can determine, has no weight; a plain mean consists of such entries for
// the most part.

// The weights of the 39 entries, shape [39]: those of c11 and c22 over all rows have the sum 1, c12
// and c33 none; those of bend have the sum 1. shapes: [m], [3V] each, at least one.
Eigen::VectorXd StiffnessWeights(const ClothModel& model,
                                 const std::vector<Eigen::VectorXd>& shapes);
// Equal weights for the entries of c11 and c22 and for those of bend: plain means, where there is
// no drape.
Eigen::VectorXd EqualStiffnessWeights();

// The membrane stiffness along the threads [N/m] and the plate rigidity [N·m] of one table of each
// kind [MODEL, M7, M8]. weights: shape [39].
double EffectiveStretch(const MaterialField& table, const Eigen::VectorXd& weights);
double EffectiveBend(const MaterialField& table, const Eigen::VectorXd& weights);

// What the two directions of the threads are called.
struct DirectionNames {
  std::string warp = "warp", weft = "weft";
};
// Warp and weft, or "stiffer" and "softer" by their rigidities where it is not known which is
// which.
DirectionNames NameDirections(bool warp_known, double bend_warp, double bend_weft);

// One of the numbers by which a person compares two cloths.
struct StiffnessQuantity {
  std::string key;   // of JSON files, with the unit of the value
  std::string name;  // for a person
  const char* unit;  // in which a person reads scale·value
  double scale;
  double value;
};

// The means of the columns of stretch [N/m] and of the rows of bend [N·m] of one table of each kind
// [MODEL, M7, M8]; then the rigidity as drapes show it, also by weight [m³] and as a bending length
// [m]. weights: StiffnessWeights, shape [39].
std::vector<StiffnessQuantity> ListStiffness(const MaterialField& table,
                                             const Eigen::VectorXd& weights,
                                             const DirectionNames& directions);

}  // namespace drape
