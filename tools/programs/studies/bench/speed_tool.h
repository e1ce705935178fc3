// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/util/run_control.h"
#include "solver/studies/bench/speed_table.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_speed sets.
struct SpeedToolOptions {
  SpeedJob job;           // meshes: none: built-in discs of the published numbers of vertices
  std::string published;  // ReadPublishedSpeeds; empty: none
  std::string out;        // folder, made when missing
};

// Points into `options`, which outlives it.
OptionTable SpeedOptionTable(SpeedToolOptions& options);

struct SpeedToolResult {
  SpeedTable table;
  std::string text;  // the table, for a person
};

// Measures, and writes speed.md and speed.json to options.out. A cancelled run writes nothing.
// Throws InputError.
SpeedToolResult RunSpeedTool(const SpeedToolOptions& options, const RunControl& control);

// The program drape_speed.
int SpeedMain(int argc, char** argv);

}  // namespace drape
