// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "losses/metrics/laboratory_drape.h"
#include "physics/material/material.h"
#include "physics/util/options/field.h"
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
  // What the fit states of the fabric (ReadSheet "material"); nothing without its summary.
  std::optional<LaboratorySheet> sheet = {};
};

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

// The space of materials: how far fabrics are apart, the population that they are drawn from, and
// how likely a further material is in it [METHODS, P60, P61].

// Distances of two distributions in z. Wasserstein is in log units.
struct Distances {
  double divergence = 0.0, reverse_divergence = 0.0;  // KL(first ‖ second), KL(second ‖ first)
  double jeffreys = 0.0, bhattacharyya = 0.0, hellinger = 0.0, wasserstein = 0.0;
};

struct PairDistances {
  int first = 0, second = 0;               // of the fabrics
  int directions = 0;                      // that the data of both determine (DeterminedDirections)
  std::vector<Distances> all = {};         // by level (SpaceFrame::Levels), in all directions
  std::vector<Distances> determined = {};  // in those directions; zero where there is none
  // The share of the squared Wasserstein metric of all directions that lies outside of those: by
  // the prior, not by the data. By level.
  std::vector<double> share_of_prior = {};
};

// A material as the space judges it.
struct JudgedMaterial {
  std::string name;
  double log_likelihood = 0.0;  // of what is known of it, under the population [nat]
  // The share of left-out fabrics, itself included, that are no more likely.
  double p_value = 1.0;
  // ln Σ_f weight_f·p(· | fabric f) over the fabrics of the space.
  double log_mixture = 0.0;
  std::vector<double> by_fabric = {};  // probability of each fabric, by the mixture
  Eigen::VectorXd place = {};          // mean in the leading directions
  Eigen::VectorXd determined = {};     // mean in the determined directions, in z
};

struct MaterialSpace {
  FabricBeliefs beliefs;
  std::vector<PairDistances> pairs = {};  // (0, 1), (0, 2), …, (1, 2), …
  // How many directions all fabrics together determine, by the mean of their covariances, and
  // those; where there is none, and of kind bdp, all directions.
  int determined = 0;
  DeterminedDirections directions = {};
  // The fabrics at the level of specimens (or elements) in those directions, in z.
  std::vector<NormalDistribution> fabrics = {};
  // Their Wasserstein metric [log units], and the Hellinger metric of each pair in its own
  // determined directions; NaN for a pair without one.
  Eigen::MatrixXd wasserstein = {}, hellinger = {};

  // The population, in the leading directions in z: at most kMostLeading, and fewer than half of
  // the fabrics. Not of kind bdp, whose numbers have no uncertainty, nor where no direction is
  // determined.
  DeterminedDirections leading = {};
  NormalMixture population = {};
  ComponentChoice choice = {};
  std::vector<JudgedMaterial> left_out = {};     // each fabric, by the others
  std::vector<JudgedMaterial> non_fabrics = {};  // invented ones
  std::vector<JudgedMaterial> added = {};
  std::vector<FabricBelief> added_beliefs = {};
  // The prior of another fabric's θ: the population in the leading directions, the prior of the
  // fits in the others.
  NormalDistribution prior = {};

  bool has_population() const { return population.size() > 0; }
};
inline constexpr int kMostLeading = 6;

// added: further materials (ReadFabricBelief), judged but no part of the space.
MaterialSpace BuildMaterialSpace(FabricBeliefs beliefs, std::vector<FabricBelief> added);

// What the data alone say of a fabric in some directions in z (WithoutPrior).
NormalDistribution Evidence(const SpaceFrame& frame, const FabricBelief& fabric,
                            const Eigen::MatrixXd& axes);

// Bending lengths of specimens along weft and warp, ln [m]: (D/ρg)^⅓ with D the mean of a row of
// the table [ASTM D1388]. An edge along the weft bends the warp.
NormalDistribution LogBendingLengths(const SpaceFrame& frame, const FabricBelief& fabric);

}  // namespace drape
