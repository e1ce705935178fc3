// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// The choice of a model [METHODS, P45]: the simplest model whose held-out
// score is within one standard error of the best.

// Scores of one model, the lower the better, one for each held-out capture, in the same order for
// all models.
struct ModelScores {
  std::string model;
  std::vector<double> scores;
};

// A model's scores less those of the best model, capture by capture: what is hard to predict for
// both cancels, so this standard error is smaller than that of either mean. It takes captures as
// independent; those of one sample repeat each other, so the true one is up to √(captures of a
// sample) times as large.
struct ScoreDifference {
  std::string model;
  double mean_score = 0.0;
  double mean = 0.0;            // of the differences, ≥ 0
  double standard_error = 0.0;  // their standard deviation / √n; 0 of the best, and where n = 1
  bool within() const { return mean <= standard_error; }
};

struct ModelChoice {
  std::string best;    // of least mean score, the simplest of equals
  std::string chosen;  // the simplest within one standard error of it; both empty without models
  int captures = 0;
  std::vector<ScoreDifference> differences;  // in the order of the models
};

// `models` from the simplest on; all have the same number of scores, at least one (CHECK).
ModelChoice ChooseSimplest(const std::vector<ModelScores>& models);

}  // namespace drape
