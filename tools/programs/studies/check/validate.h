// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/studies/validation/validation.h"
#include "tools/cli/option_table.h"

namespace drape {

// What drape_validate measures and where it writes.
struct ValidateToolOptions {
  ValidationOptions validation;
  std::string out;
};

OptionTable ValidateTable(ValidateToolOptions& options);

// Computes the reference cases and writes summary.json; a cancelled run keeps the groups that are
// complete, and its "complete" is false. Throws InputError.
std::vector<ReferenceCase> RunValidation(const ValidateToolOptions& options,
                                         const RunControl& control);

// One row per reference case, then how many failed.
std::string ValidationText(const std::vector<ReferenceCase>& cases);

// The program drape_validate.
int ValidateMain(int argc, char** argv);

}  // namespace drape
