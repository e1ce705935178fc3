// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "tools/cli/progress.h"
#include "tools/cli/run_tool.h"
#include "tools/programs/equilibria/equilibria_report.h"

namespace {

drape::EquilibriumSurvey Run(const drape::EquilibriaOptions& options,
                             const std::atomic<bool>& cancel) {
  drape::Progress progress("branches");
  const auto report = [&](double fraction, const std::string& note) {
    progress.Update(fraction, note);
  };
  const auto say = [&](const std::string& line) { progress.Say(line); };
  return drape::SurveyEquilibria(options, {&cancel, report, say});
}

}  // namespace

int main(int argc, char** argv) {
  drape::EquilibriaOptions options;
  const auto body = [&](const std::atomic<bool>& cancel) {
    const drape::EquilibriumSurvey survey = Run(options, cancel);
    std::printf("%s", drape::EquilibriaTableText(survey).c_str());
    if (survey.cancelled) return drape::kExitCancelled;
    if (survey.spread.drapes > 0) return drape::kExitOk;
    std::fprintf(stderr, "drape_equilibria: failed: no start came to rest, see summary.json\n");
    return drape::kExitNumerical;
  };
  return drape::RunTool(argc, argv, drape::EquilibriaTable(options), body);
}
