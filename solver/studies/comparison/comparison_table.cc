// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/comparison_table.h"

#include <set>
#include <tuple>

namespace drape {
namespace {

using Cells = std::vector<const ComparedExperiment*>;

Cells ListRuns(const std::vector<ComparedExperiment>& cells, int fabric, const std::string& model) {
  Cells found;
  for (const ComparedExperiment& cell : cells)
    if (cell.model == model && (fabric == 0 || cell.fabric == fabric)) found.push_back(&cell);
  return found;
}

bool Failed(const ComparedExperiment& cell) { return !cell.result.failure.empty(); }

// The values of one number, one for each seed for which every cell has it.
std::vector<double> ListValues(const Cells& cells, const std::string& key) {
  std::map<int, std::vector<double>> by_seed;
  std::map<int, std::size_t> wanted;
  for (const ComparedExperiment* cell : cells) {
    ++wanted[cell->seed];
    const auto number = cell->result.numbers.find(key);
    if (number != cell->result.numbers.end()) by_seed[cell->seed].push_back(number->second);
  }
  std::vector<double> values;
  for (const auto& [seed, numbers] : by_seed)
    if (numbers.size() == wanted[seed]) values.push_back(SpreadOfValues(numbers).mean);
  return values;
}

ComparisonRow MakeRow(const Cells& cells, const std::string& model) {
  ComparisonRow row{model, static_cast<int>(cells.size()), 0, {}};
  for (const ComparedExperiment* cell : cells) row.failed += Failed(*cell);
  for (const ComparedNumber& number : kComparedNumbers) {
    const std::vector<double> values = ListValues(cells, number.key);
    if (!values.empty())
      row.numbers[number.key] = {SpreadOfValues(values), static_cast<int>(values.size())};
  }
  return row;
}

// The mean score over the seeds of each capture that was held out, in the captures' order.
ModelScores ListScores(const Cells& cells, const std::string& model) {
  std::map<std::tuple<int, int, int>, std::vector<double>> scores;
  for (const ComparedExperiment* cell : cells)
    for (const CaptureScore& capture : cell->result.captures)
      scores[{capture.fabric, capture.sample, capture.capture}].push_back(capture.feature_energy);
  ModelScores all{model, {}};
  for (const auto& [capture, of_seeds] : scores)
    all.scores.push_back(SpreadOfValues(of_seeds).mean);
  return all;
}

ComparisonTable MakeTable(const std::vector<ComparedExperiment>& cells, int fabric,
                          const std::vector<std::string>& models,
                          const std::vector<std::string>& others) {
  ComparisonTable table{fabric, {}, {}};
  std::vector<ModelScores> candidates;
  for (const std::string& model : models) {
    const Cells of_model = ListRuns(cells, fabric, model);
    table.rows.push_back(MakeRow(of_model, model));
    if (!of_model.empty() && table.rows.back().failed == 0)
      candidates.push_back(ListScores(of_model, model));
  }
  for (const std::string& other : others) {
    const Cells of_other = ListRuns(cells, fabric, other);
    if (!of_other.empty()) table.rows.push_back(MakeRow(of_other, other));
  }
  table.choice = ChooseSimplest(candidates);
  return table;
}

std::optional<PosteriorStiffnessRow> ComputePosteriorStiffness(const Cells& cells) {
  PosteriorStiffnessRow row;
  double count = 0;
  for (const ComparedExperiment* cell : cells) {
    if (!cell->result.belief) continue;
    const ExperimentStiffness& belief = *cell->result.belief;
    row.fabric = cell->fabric;
    row.model = cell->model;
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

Comparison SumUp(const std::vector<ComparedExperiment>& cells,
                 const std::vector<std::string>& models, const std::vector<std::string>& others) {
  Comparison comparison;
  std::set<int> fabrics;
  for (const ComparedExperiment& cell : cells) fabrics.insert(cell.fabric);
  for (const int fabric : fabrics) {
    comparison.tables.push_back(MakeTable(cells, fabric, models, others));
    for (const std::string& model : models)
      if (const auto belief = ComputePosteriorStiffness(ListRuns(cells, fabric, model)))
        comparison.beliefs.push_back(*belief);
  }
  if (fabrics.size() > 1) comparison.tables.push_back(MakeTable(cells, 0, models, others));
  for (const ComparedExperiment& cell : cells)
    if (Failed(cell))
      comparison.failures.push_back("fabric " + std::to_string(cell.fabric) + ", " + cell.model +
                                    ", seed " + std::to_string(cell.seed) + ": " +
                                    cell.result.failure);
  return comparison;
}

}  // namespace drape
