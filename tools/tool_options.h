// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/check_report.h"
#include "tools/drape_view.h"
#include "tools/fit_tool.h"
#include "tools/option_table.h"
#include "tools/simulate.h"

namespace drape {

// The options of each tool. A table points into `options`, which outlives it.
OptionTable SimulateTable(SimulateOptions& options);
OptionTable CheckTable(CheckToolOptions& options);
OptionTable FitTable(FitToolOptions& options);

// The part of a table that names the cloth: mesh, material, law.
std::vector<Option> ClothOptions(SceneInput& scene);
// The part that sets the camera.
std::vector<Option> CameraOptions(CameraInput& camera);

}  // namespace drape
