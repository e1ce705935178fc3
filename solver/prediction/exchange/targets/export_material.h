// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "physics/util/options/field.h"
#include "solver/prediction/exchange/exchange_record.h"

namespace drape {

// The programs and formats that a fabric can be taken to [METHODS, P70].
enum class ExportTarget { kArcsim, kClo, kNewton, kStyle3d, kPpf, kBlender, kJson };
constexpr auto EnumNames(ExportTarget) {
  return MakeNames<ExportTarget>({{ExportTarget::kArcsim, "arcsim"},
                                  {ExportTarget::kClo, "clo"},
                                  {ExportTarget::kNewton, "newton"},
                                  {ExportTarget::kStyle3d, "style3d"},
                                  {ExportTarget::kPpf, "ppf"},
                                  {ExportTarget::kBlender, "blender"},
                                  {ExportTarget::kJson, "json"}});
}
inline constexpr ExportTarget kExportTargets[] = {
    ExportTarget::kArcsim, ExportTarget::kClo,     ExportTarget::kNewton, ExportTarget::kStyle3d,
    ExportTarget::kPpf,    ExportTarget::kBlender, ExportTarget::kJson};

struct ExportOptions {
  IsotropicChoice keep = IsotropicChoice::kNearest;  // of targets with an isotropic membrane
};

// A fabric in the form of one target.
struct ExportedMaterial {
  std::string file;      // name of the file: "arcsim.json"
  std::string text;      // its content
  MaterialField tables;  // what its numbers mean in this simulator
  std::string use;       // how to load it there, in one sentence
  std::vector<std::string> lost;
  bool verified = false;  // the target, or a reader of its format, has given the same result
  std::string evidence;   // what has been compared, and what has not
};
ExportedMaterial ExportMaterial(ExportTarget target, const ExchangeRecord& record,
                                const ExportOptions& options = {});

}  // namespace drape
