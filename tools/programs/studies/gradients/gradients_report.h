// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/cli/output_folder.h"
#include "tools/programs/studies/gradients/gradients_tool.h"

namespace drape {

// All files of drape_gradients.
void WriteGradientReport(const GradientStudy& study, const OutputFolder& out);

}  // namespace drape
