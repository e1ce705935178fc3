// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/programs/results/export/export_tool.h"

namespace drape {

// The record, and of each target its file, what is lost and the round trip.
std::string ExportText(const ExportRun& run);
void WriteExportSummary(const std::string& path, const ExportToolOptions& options,
                        const ExportRun& run);

}  // namespace drape
