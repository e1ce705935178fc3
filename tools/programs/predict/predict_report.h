// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/dataset/trivial_predictors.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/prediction/prediction.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// Silhouettes of a user's own to learn a fabric from.
struct TrainingImages {
  std::vector<std::string> images;  // files, folders, patterns (ExpandImages)
  std::vector<int> samples;         // of each image, from 1; empty: each shows its own
  std::vector<std::string> faces;   // of each, "up" or "down"; empty: all up
};

// The options of drape_predict.
struct PredictToolOptions {
  SceneInput scene;    // its start is not used
  bool learn = false;  // instead of its fabric: from images or the side of the split to learn from
  TrainingImages images;     // with `learn`; none: of the data set
  std::string specimens;     // instead of these: file of an earlier run that learned
  LearningOptions learning;  // RunPrediction sets its mesh, seeds, steps and threads
  int pool_seed = 1;
  PredictionOptions prediction;  // RunPrediction sets its specimens, faces, seed, camera, batch
  int draws = 64;                // drapes in all
  int seed = 1;
  int threads = 0;         // 0: all cores
  DatasetQuery data;       // scored where it has a folder; its face is that of the draws too
  bool calibrate = false;  // on the side of the split to learn from
  CameraInput camera;
  std::string backend = "auto";  // MakeBackend
  bool keep_meshes = false;
  std::string out;  // folder, made when missing
};

// The results of drape_predict, for its report.
struct PredictionRun {
  bool cancelled = false;
  std::string backend;  // Backend::name
  LoadedScene scene;    // without a fabric where it is learned
  PredictionOptions prediction;
  std::optional<BendCalibration> calibration;       // `prediction` has its factors
  std::optional<LearnedFabric> learned;             // of a file: its fit alone
  std::map<ClothFace, SpecimenPosterior> specimen;  // learned from one sample: what it can be
  std::vector<PredictedDrape> drapes;
  std::optional<DatasetReport> data;
  std::optional<DistributionScore> score;  // ScorePrediction on the data held out
  double seconds = 0.0;

  int at_rest() const;
};

// The distribution of each feature, the samples that did not come to rest, and the scores beside
// those of the trivial predictors.
std::string PredictionText(const PredictionRun& run);

// Throws InputError when the file cannot be written.
void WritePredictionSummary(const std::string& path, const PredictToolOptions& options,
                            const PredictionRun& run);

// Writes the outlines of the drapes that were seen, a group for each specimen. Throws InputError
// when the file cannot be written.
void WritePredictedOutlines(const std::string& path, const PredictionRun& run);

}  // namespace drape
