// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "solver/posterior/space/fabric_belief.h"
#include "solver/posterior/space/normal_mixture.h"

namespace drape {

// The space of materials: how far fabrics are apart, the population that they are drawn from, and
// how likely a further material is in it [METHODS, P60, P61].

// Of two distributions, in z; Wasserstein in log units.
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
  std::vector<JudgedMaterial> non_fabrics = {};  // invented ones (MakeNonFabrics)
  std::vector<JudgedMaterial> added = {};
  std::vector<FabricBelief> added_beliefs = {};
  // The prior of another fabric's θ: the population in the leading directions, the prior of the
  // fits in the others.
  NormalDistribution prior = {};

  bool has_population() const { return population.size() > 0; }
};
inline constexpr int kMostLeading = 6;
inline constexpr int kMostComponents = 4;

// added: further materials (ReadFabricBelief), judged but no part of the space.
MaterialSpace BuildMaterialSpace(FabricBeliefs beliefs, std::vector<FabricBelief> added);

// Materials that are no fabrics, as points: paper, and the median table of the fabrics with its
// stretch × 100, with one isotropic rigidity of 1e-4 N·m, and with a ratio of 30 between warp and
// weft; but those that have no log factors on the base.
std::vector<FabricBelief> MakeNonFabrics(const FabricBeliefs& beliefs);

// What the data alone say of a fabric in some directions in z (WithoutPrior).
NormalDistribution Evidence(const SpaceFrame& frame, const FabricBelief& fabric,
                            const Eigen::MatrixXd& axes);

// Bending lengths of specimens along weft and warp, ln [m]: (D/ρg)^⅓ with D the mean of a row of
// the table [ASTM D1388]. An edge along the weft bends the warp.
NormalDistribution LogBendingLengths(const SpaceFrame& frame, const FabricBelief& fabric);

}  // namespace drape
