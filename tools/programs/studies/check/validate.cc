// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/studies/check/validate.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "physics/util/text_format.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json ReferenceCaseJson(const ReferenceCase& one) {
  Json computed = Json::array();
  for (const double value : one.computed) computed.push_back(NumberOrNull(value));
  return {{"group", one.group},
          {"name", one.name},
          {"reference", one.expected},
          {"computed", computed},
          {"error", NumberOrNull(one.Error())},
          {"tolerance", one.tolerance},
          {"order", NumberOrNull(one.Order())},
          {"pass", one.Holds()}};
}

std::string RowText(const ReferenceCase& one) {
  std::string text =
      Format("%-10s %-50s %10.5g", one.group.c_str(), one.name.c_str(), one.expected);
  for (const double value : one.computed) text += Format(" %10.5g", value);
  text += Format(" %8.1e %7.0e", one.Error(), one.tolerance);
  text += std::isfinite(one.Order()) ? Format(" %5.2f", one.Order()) : Format(" %5s", "-");
  return text + Format("  %s\n", one.Holds() ? "pass" : "FAIL");
}

void WriteSummary(const std::string& path, const std::string& law, bool complete,
                  const std::vector<ReferenceCase>& cases) {
  Json json = {{"law", law}, {"complete", complete}, {"pass", AllPass(cases)}};
  json["cases"] = Json::array();
  for (const ReferenceCase& one : cases) json["cases"].push_back(ReferenceCaseJson(one));
  WriteWithProvenance(path, std::move(json));
}

}  // namespace

OptionTable ValidateTable(ValidateToolOptions& options) {
  std::string groups;
  for (const std::string& name : ValidationGroups()) groups += (groups.empty() ? "" : ", ") + name;
  return {.tool = "drape_validate",
          .summary =
              "compares simulated stiffness with textbook solutions on the built-in meshes and "
              "prints a table",
          .example = "drape_validate --filter=cantilever,disc --out=out/validate",
          .notes =
              "files: summary.json\n"
              "columns: the reference value, the values computed on three meshes, each twice as "
              "fine as the one before, the error of the finest and its bound (relative; in degrees "
              "for the angle), and the order of convergence (-: the meshes agree, or the "
              "convergence is not monotone)\n"
              "exit code 1: a reference case failed\n",
          .options = {{.key = "filter",
                       .value = &options.validation.only,
                       .doc = "groups of reference cases; none: all of " + groups},
                      LawOption(options.validation.law),
                      OutOption(options.out)}};
}

std::vector<ReferenceCase> RunValidation(const ValidateToolOptions& options,
                                         const RunControl& control) {
  const OutputFolder out(options.out, {"summary.json"});
  const std::vector<ReferenceCase> cases = Validate(options.validation, control);
  WriteSummary(out.Staged("summary.json"), options.validation.law, !control.cancelled(), cases);
  out.Publish();
  return cases;
}

std::string ValidationText(const std::vector<ReferenceCase>& cases) {
  std::string text =
      Format("%-10s %-50s %10s %10s %10s %10s %8s %7s %5s\n", "group", "reference case", "",
             "coarse", "medium", "fine", "error", "bound", "order");
  for (const ReferenceCase& one : cases) text += RowText(one);
  const auto failed =
      std::count_if(cases.begin(), cases.end(), [](const auto& one) { return !one.Holds(); });
  return text + Format("%td of %zu reference cases failed\n", failed, cases.size());
}

namespace {

ToolOutcome Run(const ValidateToolOptions& options, const RunControl& control) {
  const std::vector<ReferenceCase> cases = RunValidation(options, control);
  return {.text = ValidationText(cases),
          .cancelled = control.cancelled(),
          .exit_code = AllPass(cases) ? kExitOk : kExitCheckFailed};
}

}  // namespace

int ValidateMain(int argc, char** argv) { return ToolMain(argc, argv, ValidateTable, Run); }

}  // namespace drape
