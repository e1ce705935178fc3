// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/studies/gradients/gradient_survey.h"
#include "tools/cli/output_folder.h"

namespace drape {

// The tables of report.md.
std::string GradientReportText(const GradientStudy& study);

// All files of drape_gradients; pictures that cannot be written are noted in the study.
void WriteGradientReport(const OutputFolder& out, GradientStudy* study);

}  // namespace drape
