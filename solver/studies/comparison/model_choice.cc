// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/comparison/model_choice.h"

#include <glog/logging.h>

#include <algorithm>
#include <cmath>

#include "losses/metrics/distribution_metrics.h"

namespace drape {
namespace {

double ComputeMean(const ModelScores& model) { return SpreadOfValues(model.scores).mean; }

ScoreDifference ComputeDifference(const ModelScores& model, const ModelScores& best) {
  std::vector<double> differences;
  for (std::size_t i = 0; i < model.scores.size(); ++i)
    differences.push_back(model.scores[i] - best.scores[i]);
  const Spread spread = SpreadOfValues(differences);
  return {model.model, ComputeMean(model), spread.mean,
          spread.sd / std::sqrt(static_cast<double>(differences.size()))};
}

}  // namespace

ModelChoice ChooseSimplest(const std::vector<ModelScores>& models) {
  ModelChoice choice;
  if (models.empty()) return choice;
  for (const ModelScores& model : models) {
    CHECK(!model.scores.empty());
    CHECK_EQ(model.scores.size(), models[0].scores.size());
  }
  const auto best = std::min_element(
      models.begin(), models.end(),
      [](const ModelScores& a, const ModelScores& b) { return ComputeMean(a) < ComputeMean(b); });
  choice.best = best->model;
  choice.captures = static_cast<int>(best->scores.size());
  for (const ModelScores& model : models) {
    choice.differences.push_back(ComputeDifference(model, *best));
    if (choice.chosen.empty() && choice.differences.back().within()) choice.chosen = model.model;
  }
  return choice;
}

}  // namespace drape
