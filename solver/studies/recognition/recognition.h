// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/posterior/space/fabric_belief.h"
#include "solver/prediction/generative/distribution_fit.h"
#include "solver/studies/recognition/fabric_fits.h"
#include "solver/studies/recognition/recognition_scores.h"

namespace drape {

// By what samples and fabrics are compared.
struct RecognitionWays {
  bool posterior = true;    // A
  bool predictions = true;  // B
  bool features = true;     // of images, without a model of cloth
};

// Which fabric is a sample of? Each sample is left out with all its captures and compared with the
// fabrics as the other samples show them [METHODS, P62].
struct RecognitionJob {
  RecognitionWays ways = {};
  FitCellJob fits;                           // of each sample alone, for the posterior
  std::vector<FitCell> cells = {};           // CellsBySample
  std::vector<ObservedCapture> images = {};  // of all captures of the cells
  SpaceBy by = SpaceBy::kDrape;
  // The pool from which predictions learn; its mesh may be another than that of the fits, from
  // which it has the law, the contact and the backend.
  PoolOptions pool = {};
  std::string pool_file = {};  // ReadOrSimulatePool
  DistributionFitOptions distribution = {};
};

// Names of ways.
inline constexpr char kByPosterior[] = "posterior (A)";
inline constexpr char kByPredictions[] = "predicted drapes (B)";
inline constexpr char kByFeatures[] = "image features";
inline constexpr char kByDensity[] = "density alone, weighed to 3 %";

struct Recognition {
  bool cancelled = false;
  std::vector<int> fabrics = {};  // numbers of those with two samples or more
  std::vector<RecognisedSample> samples = {};
  std::vector<RecognitionScore> scores = {};
  std::vector<FitFailure> failures = {};  // cells without a posterior
};

// Compares by each way that job.ways has, and by products of them with nested weights. The
// posterior needs a fit of each sample, which is made where it is missing; then the samples are
// those that have one. Throws InputError.
Recognition Recognise(const RecognitionJob& job, const RunControl& control);

std::string RecognitionReport(const Recognition& recognition);

}  // namespace drape
