// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "losses/photo/photo.h"
#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_photo sets.
struct PhotoToolOptions {
  std::vector<std::string> operands;  // one photograph
  PhotoOptions photo;
  std::string out;
};

// Points into `options`, which outlives it.
OptionTable PhotoTable(PhotoToolOptions& options);

// Writes silhouette.png, camera.json, projected.png, overlay.png and summary.json to options.out,
// and returns the lines for a terminal. Throws InputError: a photograph that is refused leaves
// earlier results as they were and writes refused.png, which shows why.
std::string RunPhoto(const PhotoToolOptions& options, const RunControl& control);

}  // namespace drape
