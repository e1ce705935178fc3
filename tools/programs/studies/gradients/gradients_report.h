// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "solver/studies/gradients/gradient_survey.h"
#include "tools/cli/output_folder.h"
#include "tools/programs/results/tables/text_table.h"

namespace drape {

// The tables of report.md.
// Differences, horizons and branches, which report.md has as Markdown.
std::vector<TextTable> MakeGradientTables(const GradientStudy& study);

// All files of drape_gradients; pictures that cannot be written are noted in the study.
void WriteGradientReport(const OutputFolder& out, GradientStudy* study);

}  // namespace drape
