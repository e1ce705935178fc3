// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "losses/dataset/dataset.h"
#include "physics/util/run_control.h"
#include "solver/job/fit_spec.h"
#include "solver/studies/runner/study.h"

namespace drape {

// Many posteriors of the public data set, each in a folder of its own. A fit that fails is named
// and does not end the study.

struct FitCell {
  std::string name;               // "fabric_3", "fabric_3/sample_2": its folder below `out`
  std::vector<Capture> captures;  // of one fabric
};

struct FitCellJob {
  FitSpec fit;           // of one thread each; its model has a posterior
  std::string material;  // start tables
  std::string out;       // folder of the fits
  std::function<nlohmann::ordered_json()> provenance = {};  // FitFiles::provenance of each fit
  nlohmann::json settings = {};                             // Study::settings
  StudyOptions study = {};                                  // its threads: fits side by side
};

// One cell for each fabric, or for each sample. The captures are in the order of the data set.
std::vector<FitCell> CellsByFabric(const std::vector<Capture>& captures);
std::vector<FitCell> CellsBySample(const std::vector<Capture>& captures);

struct FitFailure {
  std::string name, reason;
};

struct FitCellRun {
  StudyResult study;
  std::vector<std::string> done = {};  // names of cells with a posterior, in their order
  std::vector<FitFailure> failures = {};
};

// Fits the missing cells, each from its checkpoint if it has one. A fit remembers why it failed, as
// for an image without a drape; a refusal of the system, such as a full disk, ends the study and is
// not remembered. Throws InputError and IoError.
FitCellRun RunFitCells(const FitCellJob& job, const std::vector<FitCell>& cells,
                       const RunControl& control);

}  // namespace drape
