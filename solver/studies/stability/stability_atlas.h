// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/cells/share.h"
#include "solver/studies/stability/stability_survey.h"
#include "solver/studies/stability/stability_theory.h"

namespace drape {

struct StabilityAtlasOptions {
  std::string runs;     // runs.csv, to which each finished run is appended
  std::string shared;   // what all runs share (WriteStabilityRuns)
  bool resume = false;  // keep the runs that the file holds
  std::string cells;    // folder of the runs of shares (CellFolder)
  // Of the runs; none: all. A share keeps its runs in `cells`, and has no file of runs; an atlas
  // of all takes the finished ones over.
  std::optional<Share> share = {};
  std::vector<double> damping_h = {1e-3, 1e-2, 0.05, 0.1, 0.5};  // [s]
  int threads = 1;
};

// The outcome of all runs of the maps, with the measured limits and damping beside theory.
struct StabilityAtlas {
  struct Limit {
    int map = 0;         // of `maps`
    double value = 0.0;  // on its other axis
    ExplicitLimit limit;
  };
  struct Damping {
    StabilityCase run;
    int mode = 0;
    StepDamping damping;
  };

  bool cancelled = false;
  std::vector<StabilityMap> maps;
  StabilityRuns runs;
  std::vector<Limit> limits;  // of the explicit maps over h
  std::vector<Damping> damping;
  double seconds = 0.0;
  std::string note;  // on what its report lacks, with an end of line; empty: nothing

  // Of the cases of a map in their order, kNoRun where one is missing.
  std::vector<int> ListOutcomes(const StabilityMap& map) const;
  StabilityLine MakeLine(int map) const;
};

// Throws what the scenes of a run would throw.
void CheckScenes(const StabilityRunner& runner, const std::vector<StabilityMap>& maps);

// The names of the runs of the maps in their order, each once (StabilityInputs).
std::vector<std::string> ListStabilityCells(const std::vector<StabilityMap>& maps);

// A cancelled atlas has the runs that are complete; that of a share has its runs and no theory.
// Atlases of other shares may have the same folder at the same time. control.cancel is not null.
// Throws InputError.
StabilityAtlas MakeStabilityAtlas(StabilityRunner& runner, std::vector<StabilityMap> maps,
                                  const StabilityAtlasOptions& options, const RunControl& control);

}  // namespace drape
