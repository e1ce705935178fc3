// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/tool_fixture.h"
#include "tools/programs/results/report/report_tool.h"

namespace drape::test {

inline const std::string kReport = std::string(DRAPE_BIN_DIR) + "/drape_report";

class ReportTest : public ToolFixture {
 protected:
  std::string AddFit(const std::string& name, const Json& more) const {
    std::filesystem::create_directories(Path(name));
    Json summary = {{"tool", "drape_fit"}, {"start_material", "a<b>.json"}};
    summary.update(more);
    Write(name + "/summary.json", summary.dump());
    return Path(name);
  }
  // A folder of another program by what its summary has.
  std::string AddResult(const std::string& name, const Json& summary) const {
    std::filesystem::create_directories(Path(name));
    Write(name + "/summary.json", summary.dump());
    return Path(name);
  }
  std::string Page(const std::vector<std::string>& folders, double max_mb = 2.0) const {
    std::vector<ResultFolder> read;
    for (const std::string& folder : folders) read.push_back(ReadResultFolder(folder));
    return MakeReport(read, max_mb);
  }
};

}  // namespace drape::test
