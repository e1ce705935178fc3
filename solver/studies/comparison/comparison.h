// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/job/fit_job.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/prediction/prediction.h"
#include "solver/studies/runner/study.h"

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

// Fits models of fabrics to the same images and scores them on the same held-out captures.
struct ComparisonJob {
  std::string data;  // folder of the public data set
  std::vector<int> fabrics;
  std::vector<std::string> models;  // names of ComparedModels
  std::vector<int> seeds;           // each draws the split, the posterior's and the drapes' draws
  // Start tables: one for all fabrics, or one for each.
  std::vector<std::string> materials = {kBuiltInName};
  int train = 6;                    // samples of a fabric to learn from
  std::vector<int> train_captures;  // of these samples; empty: all
  std::optional<ClothFace> face;    // of all captures; none: both
  int draws = 64;                   // drapes of a prediction
  bool calibrate = true;            // each fit before its prediction (CalibrateBend)
  FitSpec fit;                      // of all models, which change their part of it
  std::function<nlohmann::ordered_json()> provenance;  // FitFiles::provenance of each fit
  LearningOptions learning;  // of the generative model; its fit's seed is not used
  nlohmann::json settings;   // Study::settings
  std::string out;           // folder of the runs
  bool list = false;         // StudyOptions::list: reads no file
};

struct Comparison {
  // The cells are the runs "fabric_3/homogeneous/seed_1", by fabric, seed and model, in folders of
  // these names below `out`, beside fabric_<N>/split_<K>.json.
  Study study;
  // The numbers of a complete study: {"format", "version", "models": [{"name", "meaning"}],
  // "runs": [{"fabric", "model", "seed", …}]} with the results of RunExperiment, the models from
  // the simplest on. The trivial predictors "other samples", "normal" and "circle" are runs too;
  // they learn from the captures that are fitted.
  std::function<nlohmann::ordered_json(const StudyResult& result)> summarise;
};

// Reads and checks all input. Throws InputError.
Comparison MakeComparison(const ComparisonJob& job, const RunControl& control);

}  // namespace drape
