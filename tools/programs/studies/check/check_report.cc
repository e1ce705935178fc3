// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/check/check_report.h"

#include <algorithm>

#include "physics/util/text_format.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {

std::string CheckTableText(const std::vector<CheckRow>& rows) {
  std::string text =
      Format("%-10s %-58s %9s %9s\n", "group", "check (relative errors)", "value", "bound");
  for (const CheckRow& row : rows) {
    text += Format("%-10s %-58s %9.1e ", row.group.c_str(), row.name.c_str(), row.value);
    if (row.has_bound()) {
      text += Format("%9.0e  %s\n", row.bound, row.ok() ? "ok" : "FAIL");
    } else {
      text += Format("%9s\n", "-");
    }
  }
  const auto bounded =
      std::count_if(rows.begin(), rows.end(), [](auto& row) { return row.has_bound(); });
  const auto failed = std::count_if(rows.begin(), rows.end(), [](auto& row) { return !row.ok(); });
  return text + Format("%td of %td checks failed\n", failed, bounded);
}

OptionTable CheckTable(CheckToolOptions& options) {
  const std::vector<Option> checks = {
      TimeStepOption(options.check.h, "time step of the rollouts"),
      {.key = "steps",
       .value = &options.check.steps,
       .doc = "number of time steps of the rollouts",
       .least = 1,
       .most = 1000},
      {.key = "seed",
       .value = &options.check.seed,
       .doc = "random seed of the run: of the directions and the noise",
       .least = 0},
      {.key = "noise",
       .value = &options.check.noise,
       .doc = "random offset of the start, which breaks its symmetry",
       .unit = "mean edge lengths",
       .least = 0,
       .most = 1},
  };
  return {.tool = "drape_check",
          .summary = "checks the forces, energies and derivatives of a scene and prints a table",
          .example = "drape_check --config=configs/programs/check.json --law=reference",
          .notes = "exit code 1: a check failed\n",
          .options = Concatenate(SceneOptions(options.scene), checks)};
}

namespace {

ToolOutcome Run(const CheckToolOptions& options, const RunControl& control) {
  const LoadedScene scene = LoadScene(options.scene);
  RequireOneTable(scene.material, "material");
  const std::vector<CheckRow> rows =
      CheckScene(scene.model, scene.material.field, scene.start, options.check, control);
  return {.text = CheckTableText(rows),
          .cancelled = control.cancelled(),
          .exit_code = AllPass(rows) ? kExitOk : kExitCheckFailed};
}

}  // namespace

int CheckMain(int argc, char** argv) { return ToolMain(argc, argv, CheckTable, Run); }

}  // namespace drape
