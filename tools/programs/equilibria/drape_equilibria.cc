// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/equilibria/equilibria_report.h"
#include "tools/programs/equilibria/equilibria_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const EquilibriaOptions& options, const RunControl& control) {
  const EquilibriumSurvey survey = SurveyEquilibria(options, control);
  return {.text = EquilibriaTableText(survey),
          .cancelled = survey.cancelled,
          .failure = survey.spread.drapes > 0 ? "" : "no start came to rest, see summary.json"};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::EquilibriaTable, drape::Run);
}
