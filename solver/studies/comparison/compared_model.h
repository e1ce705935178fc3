// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solver/job/fit_spec.h"

namespace drape {

// A model that a comparison can fit [METHODS, P43].
struct ComparedModel {
  std::string name;
  FitModel fit = FitModel::kHomogeneous;
  TableForm table_form = TableForm::kGiven;
  std::optional<ParameterTying> parameters = {};  // none: as the job says
  std::optional<FieldBasis> basis = {};           // of fields; none: as the job says
  std::string meaning;                            // for a person
  bool generative = false;  // learned from the distribution of drapes, no fit to outlines

  FitSpec ApplyTo(FitSpec spec) const;
  // Models with the same fit of one table resume from one checkpoint of this name.
  std::string TableName() const;
};

// The models of these names, the simplest first, by what a model says of a cloth rather than by its
// count of numbers. Throws InputError ("option 'models'") for an unknown or repeated name.
std::vector<ComparedModel> FindComparedModels(const std::vector<std::string>& names);

}  // namespace drape
