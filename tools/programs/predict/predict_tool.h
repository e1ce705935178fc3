// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/programs/predict/predict_result.h"

namespace drape {

// Points into `options`, which outlives it.
OptionTable PredictTable(PredictToolOptions& options);

// Reads all input before it computes. Writes to options.out summary.json, mean_image.png,
// outlines.json and, with keep_meshes, draw_<i>.obj of each drape at rest (i from 1); with
// calibrate and one material, material_up.json and material_down.json with the factors in them. A
// cancelled run writes what it has. Throws InputError; then what lay in the folder is as it was.
PredictionRun RunPrediction(const PredictToolOptions& options, const RunControl& control);

// The program drape_predict.
int PredictMain(int argc, char** argv);

}  // namespace drape
