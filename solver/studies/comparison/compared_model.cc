// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/compared_model.h"

#include <glog/logging.h>

#include <algorithm>
#include <utility>

#include "physics/util/errors.h"

namespace drape {
namespace {

std::vector<ComparedModel> MakeModelsOfOneTable() {
  return {
      {"isotropic",
       FitModel::kHomogeneous,
       TableForm::kIsotropic,
       ParameterTying::kScales,
       {},
       "linear isotropic tables, 2 numbers"},
      {"linear",
       FitModel::kHomogeneous,
       TableForm::kLinear,
       ParameterTying::kColumns,
       {},
       "linear tables, 7 numbers"},
      {"bend",
       FitModel::kHomogeneous,
       TableForm::kGiven,
       ParameterTying::kBendScale,
       {},
       "nonlinear tables, 1 number, stretch as the seed grid has it"},
      {"bend_rows",
       FitModel::kHomogeneous,
       TableForm::kGiven,
       ParameterTying::kBendRows,
       {},
       "nonlinear tables, 3 numbers, stretch as the seed grid has it"},
      {"scales",
       FitModel::kHomogeneous,
       TableForm::kGiven,
       ParameterTying::kScales,
       {},
       "nonlinear tables, 2 numbers"},
      {"columns",
       FitModel::kHomogeneous,
       TableForm::kGiven,
       ParameterTying::kColumns,
       {},
       "nonlinear tables, 7 numbers"},
      {"homogeneous",
       FitModel::kHomogeneous,
       TableForm::kGiven,
       {},
       {},
       "nonlinear tables, --num_parameters numbers"},
  };
}

std::vector<ComparedModel> MakeRicherModels() {
  return {
      {"heterogeneous",
       FitModel::kHeterogeneous,
       TableForm::kGiven,
       {},
       {},
       "and smooth fields over the cloth"},
      {"elements",
       FitModel::kHeterogeneous,
       TableForm::kGiven,
       {},
       FieldBasis::kElements,
       "and factors of each face and hinge"},
      {"bdp", FitModel::kBdp, TableForm::kGiven, {}, {}, "each face and hinge a draw of a normal"},
      {"bayes",
       FitModel::kBayes,
       TableForm::kGiven,
       {},
       {},
       "a posterior of the fabric and its specimens"},
      {"generative",
       FitModel::kHomogeneous,
       TableForm::kGiven,
       {},
       {},
       "the distribution of specimens, learned from that of drapes, 18 numbers",
       true},
  };
}

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
  static const std::vector<ComparedModel> models = [] {
    std::vector<ComparedModel> all = MakeModelsOfOneTable();
    for (ComparedModel& model : MakeRicherModels()) all.push_back(std::move(model));
    return all;
  }();
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

bool IsGenerative(const std::string& name) { return Known(name).generative; }

FitSpec WithModel(FitSpec spec, const std::string& name) {
  const ComparedModel& model = Known(name);
  spec.model = model.fit;
  spec.table_form = model.table_form;
  if (model.parameters) spec.stages.parameters = *model.parameters;
  if (model.basis) spec.fields.basis = *model.basis;
  return spec;
}

std::string TableName(const std::string& name) {
  const ComparedModel& model = Known(name);
  const bool own = model.parameters || model.table_form != TableForm::kGiven;
  return own ? "one_table_" + name : "one_table";
}

}  // namespace drape
