// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/cells/share.h"
#include "solver/studies/comparison/compared_model.h"
#include "solver/studies/comparison/comparison_table.h"
#include "solver/studies/comparison/experiment.h"

namespace drape {

// Fits models of fabrics to the same images and scores them on the same held-out captures.
struct ComparisonJob {
  std::string data;  // folder of the public data set
  std::vector<int> fabrics;
  std::vector<std::string> models;  // names of some ComparedModels
  std::vector<int> seeds;           // each draws the split, the posterior's and the drapes' draws
  std::vector<std::string> materials;  // start tables: one for all fabrics, or one of each
  int train = 6;                       // samples of a fabric to learn from
  std::vector<int> train_captures;     // of them; empty: all
  std::optional<ClothFace> face;       // of all captures; none: both
  int draws = 64;                      // drapes of a prediction
  bool calibrate = true;               // each fit before its prediction (CalibrateBend)
  FitSpec fit;                         // of all, but for what the model sets
  std::function<nlohmann::ordered_json()> provenance;  // FitFiles::provenance of each fit
  LearningOptions learning;      // of the generative model; its fit's seed is not used
  PredictionOptions prediction;  // its specimens, faces, seed and camera are not used
  std::string out;               // existing folder of the experiments
  std::optional<Share> share;    // of the experiments; none: all
  // What must be the same for experiments to be taken over from an earlier run, beside the material
  // of each fabric: key → value.
  std::map<std::string, std::string> settings;
};

struct ComparisonRun {
  bool cancelled = false;
  int experiments = 0, done = 0;  // of the share
  Comparison comparison;          // once all are done; not of a share
};

// The names of the experiments in their order, "fabric_3/homogeneous/seed_1": by fabric, seed and
// model. Throws InputError for a job that cannot be run; reads no file.
std::vector<std::string> ListComparisonCells(const ComparisonJob& job);

// Experiment by experiment: out/fabric_<N>/<model>/seed_<K>, beside out/fabric_<N>/split_<K>.json,
// and out/settings.json. Experiments that are there are taken over, so a run that was stopped goes
// on to the same answer. The split's side to learn from holds the captures that are fitted and no
// others: the trivial predictors, "other samples", "normal" and "circle", learn from the same. Runs
// of other shares may have the same folder at the same time. Reads all input before it computes.
// Throws InputError, also where `out` holds experiments of other settings.
ComparisonRun RunComparison(const ComparisonJob& job, const RunControl& control);

}  // namespace drape
