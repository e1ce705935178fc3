// SPDX-License-Identifier: Apache-2.0
#include "tools/inputs/accuracy_option.h"

#include "physics/util/atomic_file.h"
#include "physics/util/errors.h"
#include "physics/util/text_format.h"
#include "solver/forward/accuracy_table.h"
#include "tools/inputs/common_options.h"

namespace drape {
namespace {

constexpr char kBuiltIn[] = "built-in";

}  // namespace

std::vector<Option> AccuracyOptions(AccuracyChoice& choice) {
  return {
      PlainOption(
          "accuracy", &choice.accuracy,
          "accuracy to choose mesh, solve mode and time steps by: fast, balanced, exact, or an "
          "error of the outline's mean radius such as 5mm. The drape is taken to rest, so not "
          "with solve = dynamic; options that are given take precedence"),
      {.key = "accuracy_table",
       .value = &choice.table,
       .doc = "table that --accuracy chooses from; built-in: configs/accuracy.json",
       .is_path = true,
       .words = {kBuiltIn}},
  };
}

AccuracyRow PickAccuracy(const AccuracyChoice& choice, const std::string& integrator) {
  const bool built_in = choice.table == kBuiltIn;
  const AccuracyTable table =
      ParseAccuracyTable(built_in ? kBuiltInAccuracy : ReadWholeFile(choice.table),
                         built_in ? "configs/accuracy.json (built-in)" : choice.table);
  return table.Pick(choice.accuracy, integrator);
}

std::string AccuracyFilling::Line(const AccuracyRow& row) const {
  std::string line = Format("accuracy %s: %s, %s, %d steps of %g s; ", choice_.accuracy.c_str(),
                            row.mesh.c_str(), row.integrator.c_str(), row.steps, row.h);
  line += kept_.empty() ? Format(
                              "expect the mean radius of the outline within %.3g mm of that on "
                              "an infinitely fine mesh",
                              row.error_mm)
                        : "given and kept:" + kept_ + ", so no error is promised";
  return line;
}

}  // namespace drape
