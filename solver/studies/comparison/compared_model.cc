// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/compared_model.h"

#include <glog/logging.h>

#include <algorithm>

#include "physics/util/errors.h"

namespace drape {
namespace {

const ComparedModel* Find(const std::string& name) {
  for (const ComparedModel& model : ComparedModels())
    if (model.name == name) return &model;
  return nullptr;
}

const ComparedModel& Known(const std::string& name) {
  const ComparedModel* model = Find(name);
  CHECK(model != nullptr) << name;
  return *model;
}

}  // namespace

const std::vector<ComparedModel>& ComparedModels() {
  static const std::vector<ComparedModel> models = {
      {"isotropic",
       "homogeneous",
       TableForm::kIsotropic,
       ParameterTying::kScales,
       {},
       "linear isotropic tables, 2 numbers"},
      {"linear",
       "homogeneous",
       TableForm::kLinear,
       ParameterTying::kColumns,
       {},
       "linear tables, 7 numbers"},
      {"bend",
       "homogeneous",
       TableForm::kGiven,
       ParameterTying::kBendScale,
       {},
       "nonlinear tables, 1 number, stretch as the seed grid has it"},
      {"bend_rows",
       "homogeneous",
       TableForm::kGiven,
       ParameterTying::kBendRows,
       {},
       "nonlinear tables, 3 numbers, stretch as the seed grid has it"},
      {"scales",
       "homogeneous",
       TableForm::kGiven,
       ParameterTying::kScales,
       {},
       "nonlinear tables, 2 numbers"},
      {"columns",
       "homogeneous",
       TableForm::kGiven,
       ParameterTying::kColumns,
       {},
       "nonlinear tables, 7 numbers"},
      {"homogeneous",
       "homogeneous",
       TableForm::kGiven,
       {},
       {},
       "nonlinear tables, --num_parameters numbers"},
      {"heterogeneous",
       "heterogeneous",
       TableForm::kGiven,
       {},
       {},
       "and smooth fields over the cloth"},
      {"elements",
       "heterogeneous",
       TableForm::kGiven,
       {},
       FieldBasis::kElements,
       "and factors of each face and hinge"},
      {"bdp", "bdp", TableForm::kGiven, {}, {}, "each face and hinge a draw of a normal"},
      {"bayes", "bayes", TableForm::kGiven, {}, {}, "a posterior of the fabric and its specimens"},
  };
  return models;
}

std::vector<std::string> InOrderOfComplexity(const std::vector<std::string>& names) {
  std::string known;
  for (const ComparedModel& model : ComparedModels())
    known += (known.empty() ? "" : ", ") + model.name;
  for (const std::string& name : names) {
    if (Find(name) == nullptr)
      throw InputError("option 'models'", "found '" + name + "', expected some of " + known);
    if (std::count(names.begin(), names.end(), name) > 1)
      throw InputError("option 'models'", "found '" + name + "' twice, expected each once");
  }
  std::vector<std::string> ordered;
  for (const ComparedModel& model : ComparedModels())
    if (std::count(names.begin(), names.end(), model.name) > 0) ordered.push_back(model.name);
  return ordered;
}

FitJob JobOfModel(FitJob job, const std::string& name) {
  const ComparedModel& model = Known(name);
  job.model = model.fit;
  job.tables = model.tables;
  if (model.parameters) job.fit.parameters = *model.parameters;
  if (model.basis) job.fields.basis = *model.basis;
  return job;
}

std::string TableName(const std::string& name) {
  const ComparedModel& model = Known(name);
  const bool own = model.parameters || model.tables != TableForm::kGiven;
  return own ? "one_table_" + name : "one_table";
}

}  // namespace drape
