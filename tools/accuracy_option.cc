// SPDX-License-Identifier: Apache-2.0
#include "tools/accuracy_option.h"

#include "physics/atomic_file.h"
#include "physics/errors.h"
#include "solver/accuracy_table.h"
#include "tools/built_in_accuracy.h"
#include "tools/fit_tool.h"
#include "tools/simulate.h"
#include "tools/text_format.h"

namespace drape {
namespace {

constexpr char kBuiltIn[] = "built-in";

AccuracyRow Picked(const AccuracyChoice& choice, const std::string& integrator) {
  const bool built_in = choice.table == kBuiltIn;
  const AccuracyTable table =
      ParseAccuracyTable(built_in ? kBuiltInAccuracy : ReadWholeFile(choice.table),
                         built_in ? "configs/accuracy.json (built-in)" : choice.table);
  return table.Pick(choice.accuracy, integrator);
}

// Sets what the user has not given; collects the keys of what stays.
class Filling {
 public:
  explicit Filling(const AccuracyChoice& choice) : choice_(choice) {}

  template <class Value>
  void Set(const std::string& key, const Value& value, Value* option) {
    if (!choice_.given.contains(key)) {
      *option = value;
    } else if (*option != value) {
      kept_ += " --" + key;
    }
  }

  std::string Line(const AccuracyRow& row) const {
    std::string line = Format("accuracy %s: %s, %s, %d steps of %g s; ", choice_.accuracy.c_str(),
                              row.mesh.c_str(), row.integrator.c_str(), row.steps, row.h);
    line += kept_.empty() ? Format(
                                "expect the mean radius of the outline within %.3g mm of that on "
                                "an infinitely fine mesh",
                                row.error_mm)
                          : "given and kept:" + kept_ + ", so no error is promised";
    return line;
  }

 private:
  const AccuracyChoice& choice_;
  std::string kept_;
};

}  // namespace

std::vector<Option> AccuracyOptions(AccuracyChoice& choice) {
  return {
      {.key = "accuracy",
       .value = &choice.accuracy,
       .doc = "fast, balanced, exact or an error of the outline's mean radius such as 5mm: picks "
              "mesh, integrator and steps, as far as they are not given (a given one wins), and "
              "says what to expect"},
      {.key = "accuracy_table",
       .value = &choice.table,
       .doc = "what --accuracy picks from; built-in: configs/accuracy.json",
       .is_path = true,
       .words = {kBuiltIn}},
  };
}

std::string ApplyAccuracy(SimulateOptions* options) {
  const AccuracyChoice& choice = options->accuracy;
  if (choice.accuracy.empty()) return "";
  if (options->scene.scene != "cusick")
    throw InputError("option 'accuracy'", "found the scene " + options->scene.scene +
                                              ", expected cusick: the table is of the drape test");
  const bool has_integrator = choice.given.contains("integrator");
  if (has_integrator && options->integrator == "static")
    throw InputError("option 'accuracy'", "found integrator static, expected dynamic or hybrid");
  const AccuracyRow row = Picked(choice, has_integrator ? options->integrator : "");
  Filling filling(choice);
  filling.Set("mesh", row.mesh, &options->scene.mesh);
  filling.Set("integrator", row.integrator, &options->integrator);
  filling.Set("h", row.h, &options->h);
  filling.Set("steps", row.steps, &options->steps);
  return filling.Line(row);
}

std::string ApplyAccuracy(FitToolOptions* options) {
  const AccuracyChoice& choice = options->accuracy;
  if (choice.accuracy.empty()) return "";
  const bool at_rest = options->integrator == "static";
  const AccuracyRow row = Picked(choice, at_rest ? "hybrid" : "dynamic");
  Filling filling(choice);
  filling.Set("mesh", row.mesh, &options->job.mesh);
  filling.Set("settle_h", row.h, &options->job.fit.settle_h);
  filling.Set("settle_steps", row.steps, &options->job.fit.settle_steps);
  return filling.Line(row);
}

}  // namespace drape
