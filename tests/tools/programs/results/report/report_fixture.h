// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/tools/tool_fixture.h"

namespace drape::test {

inline const std::string kReport = std::string(DRAPE_BIN_DIR) + "/drape_report";

class ReportTest : public ToolFixture {
 protected:
  std::string AddFit(const std::string& name, const Json& more) const {
    Json summary = {{"start_material", "a<b>.json"}};
    summary.update(more);
    return AddResult(name, "drape_fit", summary);
  }
  std::string AddResult(const std::string& name, const std::string& program, Json summary) const {
    std::filesystem::create_directories(Path(name));
    summary["tool"] = program;
    Write(name + "/summary.json", summary.dump());
    return Path(name);
  }
  std::string Page(std::vector<std::string> folders, double max_mb = 2.0) const {
    folders.insert(folders.begin(), kReport);
    folders.push_back("--out=" + Path("page.html"));
    folders.push_back("--max_mb=" + std::to_string(max_mb));
    const ProcessResult result = RunProcess(folders);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(result.err, "");
    return Read(Path("page.html"));
  }
};

}  // namespace drape::test
