// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "physics/util/run_control.h"
#include "solver/job/fit_spec.h"
#include "solver/studies/cells/share.h"

namespace drape {

// Many fits of the public data set, each in a folder of its own, unattended: a fit that is there is
// kept, one that fails is named and does not end the run.

struct FitCell {
  std::string name;               // "fabric_3", "fabric_3/sample_2": its folder below `out`
  std::vector<Capture> captures;  // of one fabric
};

// What all fits share.
struct FitCellJob {
  FitSpec fit;                                              // of one thread each; model bayes
  std::string material;                                     // start tables
  std::string out;                                          // folder, made when missing
  int threads = 1;                                          // fits side by side
  std::function<nlohmann::ordered_json()> provenance = {};  // FitFiles::provenance of each fit
  // What must be the same for fits to be taken over from an earlier run: key → value.
  std::map<std::string, std::string> settings = {};
};

// One cell per fabric, of all of `captures` that show it, or one per sample. The captures are in
// the order of the data set.
std::vector<FitCell> CellsByFabric(const std::vector<Capture>& captures);
std::vector<FitCell> CellsBySample(const std::vector<Capture>& captures);

struct FitFailure {
  std::string name, reason;
};

struct FitCellRun {
  bool cancelled = false;
  std::vector<std::string> done = {};     // names of cells with a posterior, in their order
  std::vector<FitFailure> failures = {};  // those without, and why
  std::vector<std::string> missing = {};  // those that are still to be fitted
};

// Those of a share, if the fits are the first cells of a study.
std::vector<FitCell> CellsOfShare(const std::vector<FitCell>& cells, const Share& share);

// What there is of the cells, made by whatever process.
FitCellRun FindFits(const FitCellJob& job, const std::vector<FitCell>& cells);

// Fits the cells that have neither a posterior nor a failure.json, which is to be removed to try a
// cell again. Processes with other cells may have the same folder. Throws InputError where `out`
// holds fits of other settings.
FitCellRun RunFitCells(const FitCellJob& job, const std::vector<FitCell>& cells,
                       const RunControl& control);

}  // namespace drape
