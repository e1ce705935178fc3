// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "tools/cli/option_table.h"
#include "tools/programs/results/report/parts/result_folder.h"

namespace drape {

struct ReportOptions {
  std::vector<std::string> folders;
  std::string out = "report.html";
  double max_mb = 2.0;  // size of the page [MB]
};

OptionTable ReportTable(ReportOptions& options);

// The page of these folders. Nothing is simulated: it consists of what is stored. A part for which
// nothing is stored is left out; of drapes, pictures, charts and tables those that would make the
// page larger than that are named instead.
std::string MakeReport(const std::vector<ResultFolder>& folders,
                       double max_mb = ReportOptions().max_mb);

// Reads the folders and writes the page; returns the line for the user. Throws InputError for a
// folder without results, and when the page cannot be written.
std::string RunReport(const ReportOptions& options, const RunControl& control);

// The program drape_report.
int ReportMain(int argc, char** argv);

}  // namespace drape
