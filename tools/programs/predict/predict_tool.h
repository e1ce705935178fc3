// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "losses/camera/camera.h"
#include "losses/dataset/trivial_predictors.h"
#include "physics/util/run_control.h"
#include "solver/prediction/generative/generative_prediction.h"
#include "solver/prediction/prediction.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/scene_input.h"

namespace drape {

// Silhouettes of a user's own to learn a fabric from.
struct TrainingImages {
  std::vector<std::string> images;  // files, folders, patterns (ExpandImages)
  std::vector<int> samples;         // of each image, from 1; empty: each shows its own
  std::vector<std::string> faces;   // of each, "up" or "down"; empty: all up
};

// What a user of drape_predict sets.
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

// What drape_predict found, for its report.
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

// Points into `options`, which outlives it.
OptionTable PredictTable(PredictToolOptions& options);

// Reads all input before it computes. Writes to options.out summary.json, mean_image.png,
// outlines.json and, with keep_meshes, draw_<i>.obj of each drape at rest (i from 1); with
// calibrate and one material, material_up.json and material_down.json with the factors in them. A
// cancelled run writes what it has. Throws InputError; then what lay in the folder is as it was.
PredictionRun RunPrediction(const PredictToolOptions& options, const RunControl& control);

// The distribution of each feature, the samples that did not come to rest, and the scores beside
// those of the trivial predictors.
std::string PredictionText(const PredictionRun& run);

// Throws InputError when the file cannot be written.
void WritePredictionSummary(const std::string& path, const PredictToolOptions& options,
                            const PredictionRun& run);

// Writes the outlines of the drapes that were seen, a group for each specimen. Throws InputError
// when the file cannot be written.
void WritePredictedOutlines(const std::string& path, const PredictionRun& run);

// The program drape_predict.
int PredictMain(int argc, char** argv);

}  // namespace drape
