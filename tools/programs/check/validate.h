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

// Measures the truths, prints them as a table on stdout and writes summary.json; a cancelled run
// keeps the groups that were done, "complete" is then false. Throws InputError.
std::vector<ReferenceCase> RunValidation(const ValidateToolOptions& options);

}  // namespace drape
