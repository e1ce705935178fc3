// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/fit/fit_tool.h"

#include "tools/cli/output_folder.h"
#include "tools/cli/provenance.h"
#include "tools/cli/tool_main.h"

namespace drape {
namespace {

// "see out/fit_a.png, out/material.json"; of many pictures the first two.
std::string SeeLine(const std::string& folder, std::vector<std::string> names) {
  constexpr std::size_t kMost = 3;
  std::string line = "see ";
  if (names.size() > kMost) names.erase(names.begin() + kMost - 1, names.end() - 1);
  for (std::size_t i = 0; i < names.size(); ++i)
    line += (i == 0 ? "" : ", ") + folder + "/" + names[i];
  return line + "\n";
}

}  // namespace

FitJobResult RunFitTool(const FitToolOptions& given, const RunControl& control) {
  FitToolOptions options = given;
  const std::string picked = ApplyAccuracy(&options);
  if (!picked.empty()) control.Log(picked);
  const FitSpec spec = MakeFitSpec(options);
  const FitData data = MakeFitData(options);
  const OutputFolder out(options.out);
  FitFiles files{.out = out.Staged(""),
                 .target = options.out,
                 .checkpoint = options.out + "/checkpoint.json",
                 .resume = options.resume,
                 .log = options.out + "/fit.log",
                 .provenance = MakeProvenance};
  FitJobResult result = RunFitJob(spec, data, files, control);
  if (!picked.empty()) result.table = picked + "\n" + result.table;
  if (result.fitted) result.table += SeeLine(options.out, result.results);
  out.Publish();
  return result;
}

namespace {

ToolOutcome Run(const FitToolOptions& options, const RunControl& control) {
  FitJobResult result = RunFitTool(options, control);
  return {.text = std::move(result.table),
          .cancelled = result.cancelled,
          .failure = result.fitted ? "" : "nothing could be fitted, see summary.json"};
}

}  // namespace

int FitMain(int argc, char** argv) { return ToolMain(argc, argv, FitTable, Run); }

}  // namespace drape
