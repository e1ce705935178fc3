// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solver/job/fit_spec.h"

namespace drape {

// What a comparison can fit [METHODS, P43].
struct ComparedModel {
  std::string name;
  FitModel fit = FitModel::kHomogeneous;
  TableForm table_form = TableForm::kGiven;
  std::optional<ParameterTying> parameters = {};  // none: the job's
  std::optional<FieldBasis> basis = {};           // of fields; none: the job's
  std::string meaning;                            // for a person
  bool generative = false;  // learned from the distribution of drapes, no fit to outlines
};

// From the simplest on, in the order of what a model says of a cloth, not of its count of numbers:
// one linear table, isotropic or not; one nonlinear table of which the bend numbers alone are free
// (stretch is picked by the seed grid), or 2, 7 or the job's numbers; fields over the cloth; noise
// of each element; a hierarchy of fabric and specimens.
const std::vector<ComparedModel>& ComparedModels();
// Of these names, in that order. Throws InputError ("option 'models'") for an unknown name or one
// that comes twice.
std::vector<std::string> InOrderOfComplexity(const std::vector<std::string>& names);

bool IsGenerative(const std::string& known_name);
// `spec` with what the model of a known name sets.
FitSpec WithModel(FitSpec spec, const std::string& name);
// Models of equal fits of one table can resume from one checkpoint: "one_table", or with what sets
// theirs apart.
std::string TableName(const std::string& name);

}  // namespace drape
