// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/compared_model.h"

#include <algorithm>

#include "physics/util/errors.h"

namespace drape {
namespace {

using enum FitModel;
using Free = ParameterTying;

// Linear tables; nonlinear tables of which bending alone is free (the seed grid picks stretch), or
// 2, 7 or the job's numbers; fields over the cloth; noise of each element; a hierarchy of fabric
// and specimens; distributions of specimens.
const std::vector<ComparedModel>& AllModels() {
  constexpr TableForm kGiven = TableForm::kGiven;
  static const std::vector<ComparedModel> models = {
      {"isotropic",
       kHomogeneous,
       TableForm::kIsotropic,
       Free::kScales,
       {},
       "linear isotropic tables, 2 numbers"},
      {"linear", kHomogeneous, TableForm::kLinear, Free::kColumns, {}, "linear tables, 7 numbers"},
      {"bend",
       kHomogeneous,
       kGiven,
       Free::kBendScale,
       {},
       "nonlinear tables, 1 number, stretch from the seed grid"},
      {"bend_rows",
       kHomogeneous,
       kGiven,
       Free::kBendRows,
       {},
       "nonlinear tables, 3 numbers, stretch from the seed grid"},
      {"scales", kHomogeneous, kGiven, Free::kScales, {}, "nonlinear tables, 2 numbers"},
      {"columns", kHomogeneous, kGiven, Free::kColumns, {}, "nonlinear tables, 7 numbers"},
      {"homogeneous", kHomogeneous, kGiven, {}, {}, "nonlinear tables, --num_parameters numbers"},
      {"heterogeneous",
       kHeterogeneous,
       kGiven,
       {},
       {},
       "nonlinear tables and smooth fields over the cloth"},
      {"elements",
       kHeterogeneous,
       kGiven,
       {},
       FieldBasis::kElements,
       "nonlinear tables and factors of each face and hinge"},
      {"bdp", kBdp, kGiven, {}, {}, "each face and hinge a draw of a normal distribution"},
      {"bayes", kBayes, kGiven, {}, {}, "a posterior of the fabric and its specimens"},
      {"generative",
       kHomogeneous,
       kGiven,
       {},
       {},
       "the distribution of specimens, learned from that of drapes, 18 numbers",
       true},
  };
  return models;
}

}  // namespace

std::vector<ComparedModel> FindComparedModels(const std::vector<std::string>& names) {
  std::string known;
  std::vector<ComparedModel> found;
  for (const ComparedModel& model : AllModels()) {
    known += (known.empty() ? "" : ", ") + model.name;
    if (std::count(names.begin(), names.end(), model.name) > 0) found.push_back(model);
  }
  for (const std::string& name : names) {
    if (std::none_of(found.begin(), found.end(),
                     [&](const ComparedModel& model) { return model.name == name; }))
      throw InputError("option 'models'", "found '" + name + "', expected some of " + known);
    if (std::count(names.begin(), names.end(), name) > 1)
      throw InputError("option 'models'", "found '" + name + "' twice, expected each once");
  }
  return found;
}

FitSpec ComparedModel::ApplyTo(FitSpec spec) const {
  spec.model = fit;
  spec.table_form = table_form;
  if (parameters) spec.stages.parameters = *parameters;
  if (basis) spec.fields.basis = *basis;
  return spec;
}

std::string ComparedModel::TableName() const {
  const bool own = parameters || table_form != TableForm::kGiven;
  return own ? "one_table_" + name : "one_table";
}

}  // namespace drape
