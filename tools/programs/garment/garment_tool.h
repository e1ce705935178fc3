// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/prediction/garment/wear.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_garment sets.
struct GarmentOptions {
  std::string garment;                  // ReadPattern
  std::string body = "mannequin:walk";  // ParseBodySpec
  double body_fps = 30.0;               // of a body of OBJ files
  std::string material;                 // ReadMaterial; or
  std::string posterior;                // a folder of drape_fit (ReadMaterialSource)
  double min_relative_stiffness = 0.0;
  int draws = 1;  // of the posterior, or starts of a material
  int seed = 1;
  int threads = 0;
  std::string backend = "auto";  // MakeStepLinearSolver
  std::string law = "smooth";
  double edge = 0.012;   // of the triangles [m]
  double seconds = 4.0;  // simulated
  WearOptions wear;
  std::string out;
  bool resume = false;
};

OptionTable GarmentTable(GarmentOptions& options);

// One garment on the body, with one material.
struct GarmentRun {
  std::string name;  // "draw 3"; empty for a material
  WearResult wear;
  int vertices = 0, faces = 0;
  double smallest_gap = 0.0, largest_stretch = 0.0, hem_height = 0.0;  // [m]; of the last frame
  int body_intersections = 0, self_intersections = 0;                  // the most of a frame
  int newton_steps = 0;
  double seconds = 0.0;  // of all frames
};
struct GarmentResult {
  std::vector<GarmentRun> runs;
  bool cancelled = false;
};

// Dresses the body; of each draw, writes in a folder of its own garment.obj and garment.pc2,
// body.obj and body.pc2, and sheet.png; and summary.json of all. A cancelled run can be resumed.
// Throws InputError.
GarmentResult RunGarments(const GarmentOptions& options, const RunControl& control);

std::string GarmentText(const GarmentResult& result);
// Why not all runs have reached their end; empty otherwise.
std::string GarmentFailure(const GarmentResult& result);

// The program drape_garment.
int GarmentMain(int argc, char** argv);

}  // namespace drape
