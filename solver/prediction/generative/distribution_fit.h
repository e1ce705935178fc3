// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/forward/drape_pool.h"

namespace drape {

// The distribution of specimens whose drapes are most like the observed ones [METHODS, P72]. The
// drapes of a pool, weighted by its density over theirs, are a prediction of each distribution, so
// that its energy score is a smooth function of the distribution's numbers and no further drape is
// simulated. The minimum of the mean score over the drapes is a minimum scoring rule estimate
// [Dawid 2016]; how well it is known comes from estimates with random weights on the samples (the
// loss-likelihood bootstrap [Lyddon 2019]).
struct DistributionFitOptions {
  // The distance of two drapes is that of their features, in units of kFeatureScales, plus this
  // weight times the root mean square distance of their outlines [1/mm].
  double outline_weight = 0.2;
  // A penalty keeps the effective number of drapes, 1/Σw², of each face above this.
  double least_effective = 80.0;
  int resamples = 32;  // ≥ 0
  bool cross_validate = true;
  int iterations = 60;
  uint64_t seed = 1;
  int threads = 1;
};

// An observed drape.
struct TrainingDrape {
  int sample = 0;
  ClothFace face = ClothFace::kUnknown;  // unknown: as kUp
  DrapeShape shape;
};
std::vector<TrainingDrape> ListTrainingDrapes(const std::vector<ObservedCapture>& captures);

struct DistributionFit {
  SpecimenDistribution best;
  std::vector<SpecimenDistribution> resampled;
  std::vector<SpecimenDistribution> minima = {};  // local ones of the score, the best first
  double score = 0.0;                             // mean energy score of the drapes
  double cross_validated = 0.0;  // of each sample, by a fit to the others; NaN: not asked for
  double effective = 0.0;        // number of drapes of the worse face
  int drapes = 0;                // of the pool, near the fabric
};

// training: drapes of one fabric, of two samples or more for resampling and cross-validation.
// starts: where the search begins; then the drapes used are those within kFitReach deviations of
// them. Empty: the search begins from the mean of the drapes that are most like the observed ones,
// also with other directions of bend, and uses the drapes between their numbers. Each fit with
// random weights begins from all minima, so that an ambiguous fabric has wide intervals. Throws
// InputError (prefix "pool") where the pool has too few drapes near the fabric. A function of its
// arguments but threads. Cancelled: what is there so far.
DistributionFit FitDistribution(const DrapePool& pool, const std::vector<TrainingDrape>& training,
                                const DistributionFitOptions& options, const RunControl& control,
                                std::vector<SpecimenDistribution> starts = {});
inline constexpr double kFitReach = 4.0;

// The energy score of each drape under a distribution, shape [drapes], and the effective number of
// drapes of the pool for the worse face, if wanted. Throws InputError as FitDistribution does.
Eigen::VectorXd ScoreDrapes(const DrapePool& pool, const SpecimenDistribution& distribution,
                            const std::vector<TrainingDrape>& drapes,
                            const DistributionFitOptions& options, double* effective = nullptr);

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

// A drape of a pool, and its distance from the drapes that it is compared with.
struct NearDrape {
  int index = 0;
  double away = 0.0;
};
// The `count` drapes with the least mean distance from the seen ones (fewer where the pool has
// fewer), the nearest first; distances are those of DistributionFitOptions.
std::vector<NearDrape> ListNearestDrapes(const DrapePool& pool,
                                         const std::vector<TrainingDrape>& seen,
                                         double outline_weight, int count);

}  // namespace drape
