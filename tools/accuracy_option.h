// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include "tools/option_table.h"

namespace drape {

struct SimulateOptions;
struct FitToolOptions;

// --accuracy: mesh, integrator and steps from a table instead of by hand.
struct AccuracyChoice {
  std::string accuracy;            // AccuracyTable::Pick; empty: no choice
  std::string table = "built-in";  // "built-in": configs/accuracy.json as of the build; or a file
  std::set<std::string> given;     // options that the user has set (OptionTable::given): these win
};

std::vector<Option> AccuracyOptions(AccuracyChoice& choice);

// Sets the options that the user has not given and says in one line what was picked and which error
// to expect; empty without --accuracy. Throws InputError for an accuracy that the table has not, or
// another scene than the drape test.
std::string ApplyAccuracy(SimulateOptions* options);
std::string ApplyAccuracy(FitToolOptions* options);

}  // namespace drape
