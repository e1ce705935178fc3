// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/tool_main.h"
#include "tools/programs/studies/gradients/gradients_report.h"
#include "tools/programs/studies/gradients/gradients_tool.h"

namespace drape {
namespace {

ToolOutcome Run(const GradientsOptions& options, const RunControl& control) {
  const GradientStudy study = RunGradients(options, control);
  std::string text;
  for (const TextTable& table : MakeGradientTables(study)) {
    if (!text.empty()) text += '\n';
    text += table.Aligned();
  }
  if (!study.note.empty()) text += '\n' + study.note;
  return {.text = std::move(text), .cancelled = study.cancelled};
}

}  // namespace
}  // namespace drape

int main(int argc, char** argv) {
  return drape::ToolMain(argc, argv, drape::GradientsTable, drape::Run);
}
