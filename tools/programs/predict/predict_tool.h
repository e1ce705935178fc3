// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/prediction/bend_calibration.h"
#include "solver/prediction/prediction.h"
#include "tools/cli/option_table.h"
#include "tools/inputs/dataset_input.h"
#include "tools/inputs/drape_view.h"
#include "tools/inputs/scene_input.h"
#include "tools/programs/metrics/metrics_dataset.h"

namespace drape {

// What a user of drape_predict sets.
struct PredictToolOptions {
  SceneInput scene;              // its start is not used
  std::string posterior;         // instead of scene.material: folder of a fit (ReadMaterialSource)
  PredictionOptions prediction;  // RunPrediction sets its specimens, faces, seed, camera, batch
  int draws = 64;                // drapes in all
  int seed = 1;
  int threads = 0;         // 0: all cores
  DatasetInput data;       // scored where it has a folder; its face is that of the draws too
  bool calibrate = false;  // on the side of the split to learn from
  CameraInput camera;
  std::string backend = "auto";  // MakeBackend
  bool keep_meshes = false;
  std::string out;  // folder, made when missing
};

// Points into `options`, which outlives it.
OptionTable PredictTable(PredictToolOptions& options);

// What was found, for the reports.
struct PredictionRun {
  bool cancelled = false;
  std::string backend;  // Backend::name
  LoadedScene scene;    // without a material where a posterior is given
  std::string kind;     // of the materials (ReadMaterialSource); empty: of one material file
  PredictionOptions prediction;
  std::optional<BendCalibration> calibration;  // `prediction` has its factors
  std::vector<PredictedDrape> drapes;
  std::optional<DatasetReport> data;
  std::optional<DistributionScore> score;  // ScorePrediction on the data held out
  double seconds = 0.0;

  int at_rest() const;
};

// Reads all input before it computes. Writes to options.out summary.json, mean_image.png, draws.png
// and, with keep_meshes, draw_<i>.obj of each drape at rest (i from 1); with calibrate and one
// material, material_up.json and material_down.json with the factors in them. A cancelled run
// writes what it has. Throws InputError; then what lay in the folder is as it was.
PredictionRun RunPrediction(const PredictToolOptions& options, const RunControl& control);

}  // namespace drape
