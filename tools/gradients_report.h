// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/gradients_tool.h"
#include "tools/output_folder.h"

namespace drape {

// All files of drape_gradients.
void WriteGradientReport(const GradientStudy& study, const OutputFolder& out);

}  // namespace drape
