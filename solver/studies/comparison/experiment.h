// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/job/fit_job.h"
#include "solver/prediction/bend_calibration.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/prediction/prediction.h"
#include "solver/studies/comparison/comparison_numbers.h"

namespace drape {

// An experiment of a comparison of models: a fit to the images of one side of a split, drapes drawn
// from it, and their score on the captures of the other side.
struct ExperimentTask {
  std::string folder;  // its files; made when missing
  FitSpec fit;
  FitData data;
  std::string checkpoint;  // of the fit of one table, shared by the models of a split
  std::function<nlohmann::ordered_json()> provenance;  // FitFiles::provenance
  PredictionOptions prediction;                        // its cancel and batch are not used
  // Those of the two sides; outlive the task.
  const std::vector<ObservedCapture>* training = nullptr;
  const std::vector<ObservedCapture>* held_out = nullptr;
  std::optional<LearningOptions> learning;  // instead of a fit and its calibration
  bool calibrate = true;  // CalibrateBend before the prediction, on the training captures
};

// How well one held-out capture was predicted.
struct CaptureScore {
  int fabric = 0, sample = 0, capture = 0;
  double feature_energy = 0.0;
};

// Average stiffness of the fabric under the posterior of a model that has one (PosteriorStiffness).
struct ExperimentStiffness {
  double stretch = 0.0, stretch_deviation = 0.0;  // [N/m]
  double bend = 0.0, bend_deviation = 0.0;        // [N m]
};

struct ExperimentResult {
  std::string failure;  // empty: none; else why there is no score
  Numbers numbers;
  std::vector<CaptureScore> captures;
  std::optional<ExperimentStiffness> belief;
};

// What the files of a finished experiment say; none where one is missing or broken.
std::optional<ExperimentResult> ReadExperiment(const std::string& folder);

// Does what is still to be done: the learning (LearnFabric; to specimens.json) or the fit
// (RunFitJob; from its checkpoint, where there is one), then the prediction (SampleDrapes), whose
// scores go to prediction.json, those of a calibrated one beside those of the fit as it is; so an
// experiment that was stopped continues to the same numbers. False when it was cancelled. Throws
// InputError.
bool RunExperiment(const ExperimentTask& task, const RunControl& control);

// Mean distance of the outlines of draws and the captures of their face [m]; NaN without a pair.
double MeanPairHausdorff(const std::vector<PredictedDrape>& drapes,
                         const std::vector<ObservedCapture>& held_out);

}  // namespace drape
