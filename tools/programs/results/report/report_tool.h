// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// The program drape_report: reads the options and becomes python/drape_report.py.
int ReportMain(int argc, char** argv);

}  // namespace drape
