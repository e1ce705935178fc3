// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "solver/prediction/generative/distribution_fit.h"

namespace drape {

// A logistic map of the real line onto the numbers between two bounds.
struct BoundedNumber {
  double low, high;

  double At(double u) const { return low + (high - low) * Share(u); }
  // The u of a value, which is taken as no nearer to a bound than this share of the range.
  double From(double value, double least_share) const {
    const double share = std::clamp((value - low) / (high - low), least_share, 1.0 - least_share);
    return std::log(share / (1.0 - share));
  }
  // dAt/du.
  double Slope(double u) const { return (high - low) * Share(u) * (1.0 - Share(u)); }

 private:
  static double Share(double u) { return 1.0 / (1.0 + std::exp(-u)); }
};

// Drapes of a pool near a fabric, which with weights are a prediction of any distribution of its
// specimens, and the distances that the energy score of it takes [METHODS, P72].
struct WeightedDrapes {
  Eigen::MatrixXd numbers;       // of the drapes, shape [kSpecimenNumbers, n]
  Eigen::VectorXd log_proposal;  // shape [n]
  Eigen::MatrixXf between;       // distances of the drapes, shape [n, n]
  Eigen::MatrixXf to_captures;   // shape [n, captures]
  std::vector<int> face;         // of each capture: SpecimenDistribution::FaceIndex
  double least_effective = 0.0;  // DistributionFitOptions
};

// Of a pool, and its distance from the drapes that it is compared with.
struct NearDrape {
  int index = 0;
  double away = 0.0;
};
// The `count` drapes with the least mean distance from the seen ones (fewer where the pool has
// fewer), the nearest first; distances are those of DistributionFitOptions.
std::vector<NearDrape> ListNearestDrapes(const DrapePool& pool,
                                         const std::vector<TrainingDrape>& seen,
                                         double outline_weight, int count);

// starts: where a search begins; then the drapes are those within kFitReach deviations of them.
// Empty: filled in with what the drapes most like the observed ones suggest, and the drapes are
// those between the numbers of these. Throws InputError (prefix "pool") where there are too few.
WeightedDrapes TakeNearDrapes(const DrapePool& pool, const std::vector<TrainingDrape>& training,
                              const DistributionFitOptions& options,
                              std::vector<SpecimenDistribution>* starts);

// Whether a capture with a weight shows each face. capture_weights: shape [captures].
std::array<bool, 2> ListSeenFaces(const WeightedDrapes& drapes,
                                  const Eigen::VectorXd& capture_weights);

struct FaceScore {
  double score = 0.0;             // sum over the captures, each times its weight
  double effective = 0.0;         // number of drapes
  double penalty = 0.0;           // of too few of them
  Eigen::VectorXd by_log_weight;  // gradient of score and penalty, shape [n]
};

// The energy score of the drapes weighted for one face, for captures of these weights.
FaceScore ScoreFace(const WeightedDrapes& drapes, const SpecimenDistribution& distribution,
                    int face, const Eigen::VectorXd& capture_weights);

// The energy score of each capture, shape [captures]. *effective, if wanted: the number of drapes
// of the worse face of the captures.
Eigen::VectorXd ScoreCaptures(const WeightedDrapes& drapes,
                              const SpecimenDistribution& distribution,
                              double* effective = nullptr);

}  // namespace drape
