// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/comparison_table.h"

#include <set>
#include <tuple>

namespace drape {
namespace {

using Experiments = std::vector<const ComparedExperiment*>;

Experiments SelectExperiments(const std::vector<ComparedExperiment>& experiments, int fabric,
                              const std::string& model) {
  Experiments found;
  for (const ComparedExperiment& experiment : experiments)
    if (experiment.model == model && (fabric == 0 || experiment.fabric == fabric))
      found.push_back(&experiment);
  return found;
}

bool Failed(const ComparedExperiment& experiment) { return !experiment.result.failure.empty(); }

// The values of one number, one for each seed for which every experiment has it.
std::vector<double> ListValues(const Experiments& experiments, const std::string& key) {
  std::map<int, std::vector<double>> by_seed;
  std::map<int, std::size_t> wanted;
  for (const ComparedExperiment* experiment : experiments) {
    ++wanted[experiment->seed];
    const auto number = experiment->result.numbers.find(key);
    if (number != experiment->result.numbers.end())
      by_seed[experiment->seed].push_back(number->second);
  }
  std::vector<double> values;
  for (const auto& [seed, numbers] : by_seed)
    if (numbers.size() == wanted[seed]) values.push_back(SpreadOfValues(numbers).mean);
  return values;
}

ComparisonRow MakeRow(const Experiments& experiments, const std::string& model) {
  ComparisonRow row{model, static_cast<int>(experiments.size()), 0, {}};
  for (const ComparedExperiment* experiment : experiments) row.failed += Failed(*experiment);
  for (const ComparedNumber& number : kComparedNumbers) {
    const std::vector<double> values = ListValues(experiments, number.key);
    if (!values.empty())
      row.numbers[number.key] = {SpreadOfValues(values), static_cast<int>(values.size())};
  }
  return row;
}

// The mean score over the seeds of each capture that was held out, in the captures' order.
ModelScores ListScores(const Experiments& experiments, const std::string& model) {
  std::map<std::tuple<int, int, int>, std::vector<double>> scores;
  for (const ComparedExperiment* experiment : experiments)
    for (const CaptureScore& capture : experiment->result.captures)
      scores[{capture.fabric, capture.sample, capture.capture}].push_back(capture.feature_energy);
  ModelScores all{model, {}};
  for (const auto& [capture, of_seeds] : scores)
    all.scores.push_back(SpreadOfValues(of_seeds).mean);
  return all;
}

ComparisonTable MakeTable(const std::vector<ComparedExperiment>& experiments, int fabric,
                          const std::vector<std::string>& models,
                          const std::vector<std::string>& others) {
  ComparisonTable table{fabric, {}, {}};
  std::vector<ModelScores> candidates;
  for (const std::string& model : models) {
    const Experiments of_model = SelectExperiments(experiments, fabric, model);
    table.rows.push_back(MakeRow(of_model, model));
    if (!of_model.empty() && table.rows.back().failed == 0)
      candidates.push_back(ListScores(of_model, model));
  }
  for (const std::string& other : others) {
    const Experiments of_other = SelectExperiments(experiments, fabric, other);
    if (!of_other.empty()) table.rows.push_back(MakeRow(of_other, other));
  }
  table.choice = ChooseSimplest(candidates);
  return table;
}

std::optional<PosteriorStiffnessRow> ComputePosteriorStiffness(const Experiments& experiments) {
  PosteriorStiffnessRow row;
  double count = 0;
  for (const ComparedExperiment* experiment : experiments) {
    if (!experiment->result.belief) continue;
    const ExperimentStiffness& belief = *experiment->result.belief;
    row.fabric = experiment->fabric;
    row.model = experiment->model;
    ++count;
    for (const auto number :
         {&ExperimentStiffness::stretch, &ExperimentStiffness::stretch_deviation,
          &ExperimentStiffness::bend, &ExperimentStiffness::bend_deviation})
      row.belief.*number += (belief.*number - row.belief.*number) / count;
  }
  if (count == 0) return {};
  return row;
}

}  // namespace

Comparison SumUp(const std::vector<ComparedExperiment>& experiments,
                 const std::vector<std::string>& models, const std::vector<std::string>& others) {
  Comparison comparison;
  std::set<int> fabrics;
  for (const ComparedExperiment& experiment : experiments) fabrics.insert(experiment.fabric);
  for (const int fabric : fabrics) {
    comparison.tables.push_back(MakeTable(experiments, fabric, models, others));
    for (const std::string& model : models)
      if (const auto belief =
              ComputePosteriorStiffness(SelectExperiments(experiments, fabric, model)))
        comparison.beliefs.push_back(*belief);
  }
  if (fabrics.size() > 1) comparison.tables.push_back(MakeTable(experiments, 0, models, others));
  for (const ComparedExperiment& experiment : experiments)
    if (Failed(experiment))
      comparison.failures.push_back("fabric " + std::to_string(experiment.fabric) + ", " +
                                    experiment.model + ", seed " + std::to_string(experiment.seed) +
                                    ": " + experiment.result.failure);
  return comparison;
}

}  // namespace drape
