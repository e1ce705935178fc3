// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/util/run_control.h"
#include "solver/prediction/garment/wear_job.h"
#include "tools/cli/option_table.h"

namespace drape {

// What a user of drape_garment sets.
struct GarmentOptions {
  WearSpec spec;
  FabricInput fabric;
  int threads = 0;
  std::string backend = "auto";  // MakeStepLinearSolver
  std::string out;
  bool resume = false;
};

OptionTable GarmentTable(GarmentOptions& options);

// Runs a WearJob and writes its summary.json too. Throws InputError.
GarmentResult RunGarments(const GarmentOptions& options, const RunControl& control);

std::string GarmentText(const GarmentResult& result);
// Why not all runs have reached their end; empty otherwise.
std::string GarmentFailure(const GarmentResult& result);

// The program drape_garment.
int GarmentMain(int argc, char** argv);

}  // namespace drape
