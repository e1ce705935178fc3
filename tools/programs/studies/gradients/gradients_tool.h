// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/util/run_control.h"
#include "solver/studies/gradients/gradient_survey.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_gradients sets.
struct GradientsOptions {
  std::string mesh = "disc:300";
  std::string material;
  std::string base;  // of a material without stretch (ApplyBase)
  GradientSurveyOptions survey;
  std::string out;
};

// Points into `options`, which outlives it.
OptionTable GradientsTable(GradientsOptions& options);

// Writes to options.out summary.json, report.md, differences.png, horizons.png and fold.png; a
// cancelled run what it has. Throws InputError.
GradientStudy RunGradients(const GradientsOptions& options, const RunControl& control);

// The program drape_gradients.
int GradientsMain(int argc, char** argv);

}  // namespace drape
