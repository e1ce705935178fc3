// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/branches_report.h"
#include "tools/progress.h"
#include "tools/run_tool.h"

namespace {

drape::BranchSurvey Run(const drape::BranchesOptions& options, const std::atomic<bool>& cancel) {
  drape::Progress progress("branches");
  const auto report = [&](double fraction, const std::string& note) {
    progress.Update(fraction, note);
  };
  const auto say = [&](const std::string& line) { progress.Say(line); };
  return drape::SurveyBranches(options, {&cancel, report, say});
}

}  // namespace

int main(int argc, char** argv) {
  drape::BranchesOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::BranchSurvey survey = Run(options, cancel);
    std::printf("%s", drape::BranchTableText(survey).c_str());
    if (survey.cancelled) return drape::kExitCancelled;
    if (survey.spread.drapes > 0) return drape::kExitOk;
    std::fprintf(stderr, "drape_branches: failed: no start came to rest, see summary.json\n");
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::BranchesTable(options), body);
}
