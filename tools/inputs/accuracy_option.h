// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "solver/forward/accuracy_table.h"
#include "tools/cli/option_table.h"
#include "tools/cli/provenance.h"

namespace drape {

// configs/accuracy.json as of the build.
extern const char* const kBuiltInAccuracy;

// --accuracy: mesh, integrator and steps from a table instead of by hand.
struct AccuracyChoice {
  std::string accuracy;            // AccuracyTable::Pick; empty: no choice
  std::string table = "built-in";  // "built-in": configs/accuracy.json as of the build; or a file
  std::set<std::string> given;     // options that the user has set (OptionTable::given): these win
};

std::vector<Option> AccuracyOptions(AccuracyChoice& choice);

// The row of the chosen table for choice.accuracy; `solve`: dynamic or hybrid, empty: either.
// Throws InputError for an accuracy or a solve mode that the table does not have.
AccuracyRow PickAccuracy(const AccuracyChoice& choice, const std::string& solve);

// Sets what the user has not given and collects the keys of what stays.
class AccuracyFilling {
 public:
  explicit AccuracyFilling(const AccuracyChoice& choice) : choice_(choice) {}

  template <class Value>
  void Set(const std::string& key, const Value& value, Value* option) {
    if (!choice_.given.contains(key)) {
      RecordChoice(key, value);
      *option = value;
    } else if (*option != value) {
      kept_ += " --" + key;
    }
  }
  // One line that says what was picked and which error to expect.
  std::string Line(const AccuracyRow& row) const;

 private:
  const AccuracyChoice& choice_;
  std::string kept_;
};

}  // namespace drape
