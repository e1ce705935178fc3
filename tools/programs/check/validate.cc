// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/check/validate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "tools/cli/output_folder.h"
#include "tools/cli/versions.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

using Json = nlohmann::ordered_json;

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json ReferenceCaseJson(const ReferenceCase& truth) {
  Json computed = Json::array();
  for (const double value : truth.computed) computed.push_back(NumberOrNull(value));
  return {{"group", truth.group},
          {"name", truth.name},
          {"truth", truth.expected},
          {"computed", computed},
          {"error", NumberOrNull(truth.Error())},
          {"tolerance", truth.tolerance},
          {"order", NumberOrNull(truth.Order())},
          {"pass", truth.Holds()}};
}

void PrintRow(const ReferenceCase& truth) {
  std::printf("%-10s %-50s %10.5g", truth.group.c_str(), truth.name.c_str(), truth.expected);
  for (const double value : truth.computed) std::printf(" %10.5g", value);
  std::printf(" %8.1e %7.0e", truth.Error(), truth.tolerance);
  if (std::isfinite(truth.Order())) {
    std::printf(" %5.2f", truth.Order());
  } else {
    std::printf(" %5s", "-");
  }
  std::printf("  %s\n", truth.Holds() ? "pass" : "FAIL");
}

void PrintTable(const std::vector<ReferenceCase>& truths) {
  std::printf("%-10s %-50s %10s %10s %10s %10s %8s %7s %5s\n", "group", "truth", "", "coarse",
              "medium", "fine", "error", "bound", "order");
  for (const ReferenceCase& truth : truths) PrintRow(truth);
  const auto failed = std::count_if(truths.begin(), truths.end(),
                                    [](const ReferenceCase& t) { return !t.Holds(); });
  std::printf("%td of %zu truths failed\n", failed, truths.size());
}

void WriteSummary(const std::string& path, const std::string& law, bool complete,
                  const std::vector<ReferenceCase>& truths) {
  Json json = {{"law", law}, {"complete", complete}, {"pass", AllPass(truths)}};
  json["truths"] = Json::array();
  for (const ReferenceCase& truth : truths) json["truths"].push_back(ReferenceCaseJson(truth));
  for (const auto& [name, version] : Versions()) json["versions"][name] = version;
  WriteFileAtomically(path, json.dump(2) + "\n");
}

}  // namespace

OptionTable ValidateTable(ValidateToolOptions& options) {
  std::string groups;
  for (const std::string& name : ValidationGroups()) groups += (groups.empty() ? "" : ", ") + name;
  return {.tool = "drape_validate",
          .summary = "our stiffness against textbooks, on the built-in meshes, as a table",
          .example = "drape_validate --filter=cantilever,disc --out=out/validate",
          .notes =
              "files: summary.json\n"
              "columns: the truth, what is computed on three meshes of halved width, the "
              "error of the finest and its bound\n  (relative, in degrees for the angle), the "
              "order of convergence (-: the meshes agree, or not monotone)\n"
              "exit code 1: a truth failed\n",
          .options = {{.key = "filter",
                       .value = &options.validation.only,
                       .doc = "groups of truths, none: all of " + groups},
                      LawOption(options.validation.law),
                      OutOption(options.out)}};
}

std::vector<ReferenceCase> RunValidation(const ValidateToolOptions& options) {
  const OutputFolder out(options.out);
  const std::vector<ReferenceCase> truths = Validate(options.validation);
  PrintTable(truths);
  const auto* cancel = options.validation.cancel;
  WriteSummary(out.Staged("summary.json"), options.validation.law,
               cancel == nullptr || !cancel->load(), truths);
  out.Publish();
  return truths;
}

}  // namespace drape
