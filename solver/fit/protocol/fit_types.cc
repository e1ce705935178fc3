// SPDX-License-Identifier: Apache-2.0
#include "solver/fit/protocol/fit_types.h"

#include <glog/logging.h>

namespace drape {

void StagedFitOptions::Check() const {
  CheckFields(*this);
  grid.Check();
  CHECK(!candidates_per_round.empty() && candidates_per_round.size() == iterations.size());
}

InitialGuessOptions SearchedGrid(const StagedFitOptions& options) {
  return Refined(options.grid, options.candidates_per_round.front());
}

SettleOptions MakeSettleOptions(const StagedFitOptions& options) {
  constexpr int kGuessNewtonFactor = 2;  // a guess starts further away than a trial
  SettleOptions settle;
  settle.steps.h = options.residuals.rollout.h;
  settle.steps.steps = options.residuals.rollout.steps;
  settle.solve_mode = options.residuals.solve_mode;
  settle.equilibrium.max_iterations =
      kGuessNewtonFactor * options.residuals.equilibrium.max_iterations;
  return settle;
}

std::vector<MaterialField> ListStartTables(const FitProblem& problem) {
  std::vector<MaterialField> tables = {problem.material};
  tables.insert(tables.end(), problem.other_materials.begin(), problem.other_materials.end());
  return tables;
}

MaterialField GuessTables(const std::vector<MaterialField>& tables, const InitialGuess& guess) {
  return Scaled(tables.at(guess.table), guess.stretch, guess.bend);
}

MaterialField FittedMaterial(const StagedFitOptions& options, const FitCandidate& candidate) {
  return TableParametrisation(candidate.base, options.parameters).Material(candidate.theta);
}

int CountWanted(const StagedFitOptions& options, const StagedFitState& state) {
  return options.candidates_per_round[state.round] + (state.round == 0 && state.carried ? 1 : 0);
}

}  // namespace drape
