// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/job/fit_job.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/prediction/prediction.h"

namespace drape {

// One run of a comparison of models: a fit to the images on one side of a split, drapes drawn from
// it, and their scores on the captures of the other side.
struct ExperimentTask {
  std::string folder;  // of its files, made when missing
  FitSpec fit;
  FitData data;
  std::string checkpoint;  // of the fit of one table, shared by the models of a split
  std::function<nlohmann::ordered_json()> provenance;  // FitFiles::provenance
  PredictionOptions prediction;                        // its cancel and batch are not used
  // The captures of the two sides; they outlive the task.
  const std::vector<ObservedCapture>* training = nullptr;
  const std::vector<ObservedCapture>* held_out = nullptr;
  std::optional<LearningOptions> learning = {};  // replaces the fit and its calibration
  bool calibrate = true;  // CalibrateBend before the prediction, on the training captures
};

// Learns the distribution of specimens (LearnFabric) or fits (RunFitJob, from the checkpoint of the
// task if it has one), then draws and scores drapes. Returns
//   {"numbers": {key: number}, "captures": [{"fabric", "sample", "capture", "feature_energy",
//    "outline_energy_m"}], "score", "draws", "at_rest", "posterior"},
// or "failure" with the reason where there is no score. "numbers" has SI units; those of a fit
// without its calibration end in "_as_fitted". Returns nothing when cancelled. Throws InputError.
std::optional<nlohmann::json> RunExperiment(const ExperimentTask& task, const RunControl& control);

// What summary.json of a fit says: "numbers" and, of a model that has one, "posterior" with the
// average stiffness and its deviation; or the "failure" of the model.
nlohmann::json SummariseFit(const nlohmann::json& summary, FitModel model);

// The numbers of a score by key: errors are absolute values of predicted less observed means.
nlohmann::json ScoreNumbers(const DistributionScore& score);

}  // namespace drape
