// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/comparison/compared_model.h"
#include "solver/studies/comparison/experiment.h"
#include "solver/studies/runner/study.h"

namespace drape {

// Fits models of fabrics to the same images and scores them on the same held-out captures.
struct ComparisonJob {
  std::string data;  // folder of the public data set
  std::vector<int> fabrics;
  std::vector<std::string> models;  // names of ComparedModels
  std::vector<int> seeds;           // each draws the split, the posterior's and the drapes' draws
  std::vector<std::string> materials;  // start tables: one for all fabrics, or one for each
  int train = 6;                       // samples of a fabric to learn from
  std::vector<int> train_captures;     // of these samples; empty: all
  std::optional<ClothFace> face;       // of all captures; none: both
  int draws = 64;                      // drapes of a prediction
  bool calibrate = true;               // each fit before its prediction (CalibrateBend)
  FitSpec fit;                         // of all models, which change their part of it
  std::function<nlohmann::ordered_json()> provenance;  // FitFiles::provenance of each fit
  LearningOptions learning;      // of the generative model; its fit's seed is not used
  PredictionOptions prediction;  // its specimens, faces, seed and camera are not used
  nlohmann::json settings;       // Study::settings
  std::string out;               // folder of the runs
  bool list = false;             // StudyOptions::list: reads no file
};

struct Comparison {
  // The cells are the runs "fabric_3/homogeneous/seed_1", by fabric, seed and model, in folders of
  // these names below `out`, beside fabric_<N>/split_<K>.json.
  Study study;
  // Of a study that is complete: {"format", "version", "models": [{"name", "meaning"}],
  // "runs": [{"fabric", "model", "seed", …}]} with the results of RunExperiment, the models from
  // the simplest on. The trivial predictors "other samples", "normal" and "circle" are runs too;
  // they learn from the captures that are fitted.
  std::function<nlohmann::ordered_json(const StudyResult& result)> summarise;
};

// Reads and checks all input. Throws InputError.
Comparison MakeComparison(const ComparisonJob& job, const RunControl& control);

}  // namespace drape
