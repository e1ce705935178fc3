// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "physics/material/material_scaling.h"
#include "physics/simulation/backend.h"
#include "physics/util/options/field.h"
#include "physics/util/run_control.h"
#include "solver/fit/observed/observation.h"

namespace drape {

// Which materials and start shapes are tried on a coarse cloth [METHODS, P18].
struct InitialGuessOptions {
  std::vector<double> stretch = {1.0, 4.0, 16.0};  // factors on all stretch entries
  std::vector<double> bend = {0.06, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0};  // on all bend entries
  std::vector<double> lifts = {0.6, 0.8, 1.0};                              // of FlapsFromOutline
  double time_step = 0.1;                                                   // [s]
  int steps = 60;                                                           // of each trial

  int num_scales() const { return static_cast<int>(stretch.size() * bend.size()); }
  void Check() const;  // programmer errors
};

template <MutableOrConst<InitialGuessOptions> Options, class Visitor>
void VisitFields(Options& options, Visitor&& visit) {
  auto& [stretch, bend, lifts, time_step, steps] = options;
  visit(stretch, Field{.key = "initial_stretch",
                       .doc = "initial guesses: factors on all stretch entries",
                       .range = {.least = 0, .above_least = true}});
  visit(bend, Field{.key = "initial_bend",
                    .doc = "initial guesses: factors on all bend entries",
                    .range = {.least = 0, .above_least = true}});
  visit(lifts, Field{.key = "initial_lifts",
                     .doc = "initial guesses: height of the flaps of the start shapes",
                     .range = {.least = 0, .most = 1, .above_least = true}});
  visit(time_step, Field{.key = "initial_time_step",
                         .range = {.least = 0, .most = 10, .above_least = true},
                         .is_option = false});
  visit(steps, Field{.key = "initial_steps",
                     .doc = "initial guesses: number of time steps of each trial",
                     .range = {.least = 1, .most = 100000}});
}

// Scaled start tables, a start shape for each observation, and the misfit of the coarse drapes.
struct InitialGuess {
  int table = 0;  // number of the start tables
  double stretch = 1.0;
  double bend = 1.0;
  std::vector<double> lifts;  // shape [observations]
  double profile_rms = 0.0;   // root mean square over the observations [px]
};

// The guesses of each scale of each start table that has been tried, best first, in the order of
// the grid: bend varies fastest, tables slowest. Trials that fail numerically are left out. The
// j-th guess of a scale takes the j-th best lift of each observation.
using TriedGuesses = std::vector<std::vector<InitialGuess>>;

// Tries the scales that `tried` does not have yet, a batch at a time; `save` is called between
// batches. Fewer once *control.cancel is true. The note of control.progress is empty.
void TryInitialGuesses(Backend& coarse, const std::vector<MaterialField>& tables,
                       const std::vector<Observation>& observations,
                       const InitialGuessOptions& options, const RunControl& control,
                       TriedGuesses& tried, const std::function<void()>& save);

// The guesses of all scales, best first.
std::vector<InitialGuess> RankGuesses(const TriedGuesses& tried);

}  // namespace drape
