// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/cli/tool_main.h"
#include "tools/inputs/fit_options.h"

namespace drape {

// Fits each image of `data`, or each capture, by itself, spec.threads of them at a time, on a GPU
// many. Each fit
// writes its files to the folder of options.out that has the image's name; each.json and each.csv
// have a row for each. What cannot be fitted has a row with the reason. The same command continues
// a run that was stopped, and fits again what has changed. Throws InputError for images of one name
// and for data that belong to one fabric, such as laboratory tests.
ToolOutcome FitEach(const FitToolOptions& options, FitSpec spec, const FitData& data,
                    const RunControl& control);

}  // namespace drape
