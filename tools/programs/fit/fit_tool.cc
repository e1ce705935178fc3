// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/fit/fit_tool.h"

#include "tools/cli/output_folder.h"
#include "tools/cli/versions.h"

namespace drape {

FitJobResult RunFitTool(const FitToolOptions& given, const RunControl& control) {
  FitToolOptions options = given;
  const std::string picked = ApplyAccuracy(&options);
  if (!picked.empty()) control.Log(picked);
  const FitSpec spec = MakeFitSpec(options);
  const FitData data = MakeFitData(options);
  const OutputFolder out(options.out);
  FitFiles files{.out = out.Staged(""),
                 .checkpoint = options.out + "/checkpoint.json",
                 .resume = options.resume,
                 .log = options.out + "/fit.log"};
  for (const auto& [name, version] : Versions()) files.versions[name] = version;
  FitJobResult result = RunFitJob(spec, data, files, control);
  if (!picked.empty()) result.table = picked + "\n" + result.table;
  out.Publish();
  return result;
}

}  // namespace drape
