// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "physics/material/material.h"
#include "physics/util/options/enum_names.h"
#include "solver/posterior/posterior_io.h"
#include "solver/posterior/space/normal_mixture.h"

namespace drape {

// Posteriors of several fabrics in common coordinates: log factors of one parametrisation on one
// base table [METHODS, P60].

// Without its weight a drape determines stiffness over density only; the two are never mixed.
enum class SpaceBy {
  kDrape,  // entries over the density
  kWeight  // entries, with the density as weighed
};
constexpr auto EnumNames(SpaceBy) {
  return MakeNames<SpaceBy>({{SpaceBy::kDrape, "drape"}, {SpaceBy::kWeight, "weight"}});
}

enum class BeliefLevel {
  kFabric,    // what is known of the fabric's mean
  kSpecimen,  // of another specimen of it
  kElement    // of one face or hinge (model bdp)
};
constexpr auto EnumNames(BeliefLevel) {
  return MakeNames<BeliefLevel>({{BeliefLevel::kFabric, "fabric"},
                                 {BeliefLevel::kSpecimen, "specimen"},
                                 {BeliefLevel::kElement, "element"}});
}

// The coordinates: log factors θ on `base`, and z, the same in units of the prior.
struct SpaceFrame {
  SpaceBy by = SpaceBy::kDrape;
  PosteriorKind kind = PosteriorKind::kHierarchy;
  ParameterTying tying = ParameterTying::kEntries;
  MaterialField base;          // one table; its density is that of its entries
  Eigen::MatrixXd prior_root;  // lower triangular: the prior of θ has covariance root·rootᵀ

  int size() const { return static_cast<int>(prior_root.rows()); }
  std::vector<BeliefLevel> Levels() const;
  // A length in z times this is one in log units, where the prior's variances are equal.
  double LogUnit() const;
  // θ of a table. Throws InputError (prefix `where`) where the numbers cannot make it from the
  // base.
  Eigen::VectorXd LogFactors(const MaterialField& table, const std::string& where) const;
  bool CanRepresent(const MaterialField& table) const;  // whether LogFactors does not throw
  // The table of θ for a fabric of that density [kg/m²], which entries by drape are in proportion
  // to; by weight it is passed on.
  MaterialField Table(const Eigen::VectorXd& theta, double density) const;
  NormalDistribution ToPriorUnits(const NormalDistribution& theta) const;
  NormalDistribution FromPriorUnits(const NormalDistribution& z) const;
};

struct FabricBelief {
  std::string name, folder;
  double density = 0.0;      // [kg/m²]
  NormalDistribution theta;  // of the fabric's mean; of an element (kind bdp)
  Eigen::VectorXd centre;    // the mean of its prior
  // Standard deviations of a specimen's log factors on all stretch and on all bend entries.
  Eigen::Vector2d specimen_sd = Eigen::Vector2d::Zero();
};
// In z.
NormalDistribution BeliefAt(const SpaceFrame& frame, const FabricBelief& fabric, BeliefLevel level);

// The last parts of the folders where they differ, otherwise their paths without the parts at the
// beginning and at the end that all have in common: "fabric_3" of "out/fabric_3/sample_1".
std::vector<std::string> ShortNames(const std::vector<std::string>& folders);

struct FabricBeliefs {
  SpaceFrame frame;
  std::vector<FabricBelief> fabrics;
};

// Reads the posteriors of these folders (ReadPosterior), each of another fabric, in the coordinates
// of their common base, the geometric mean of theirs. Throws InputError for fewer than two, one
// folder twice, posteriors of different kinds, numbers or priors, and for bases that the free
// numbers cannot turn into one another.
FabricBeliefs ReadFabricBeliefs(const std::vector<std::string>& folders, SpaceBy by);

// One more, in given coordinates: of a folder, or of a material file, which is a point.
FabricBelief ReadFabricBelief(const SpaceFrame& frame, const std::string& path);

}  // namespace drape
