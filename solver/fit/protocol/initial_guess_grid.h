// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <vector>

#include "physics/material/material_scaling.h"
#include "physics/simulation/backend.h"
#include "solver/fit/observation.h"

namespace drape {

// Which materials and seed shapes are tried, on a coarse cloth [METHODS, P18].
struct InitialGuessOptions {
  std::vector<double> stretch = {1.0, 4.0, 16.0};  // factors on all stretch entries
  std::vector<double> bend = {0.06, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0};  // on all bend entries
  std::vector<double> lifts = {0.6, 0.8, 1.0};                              // of FlapsFromOutline
  double h = 0.1;                                                           // time step [s]
  int steps = 60;                                                           // of each trial

  void Check() const;  // programmer errors
};

// At least `materials` pairs of stretch × bend factors: geometric means between neighbouring bend
// factors are added until there are so many (between stretch factors where bend has but one). A
// single pair cannot be refined.
InitialGuessOptions Refined(InitialGuessOptions grid, int materials);

// A material scale and a seed for each target, and how near its coarse drapes come.
struct InitialGuess {
  double stretch = 1.0;
  double bend = 1.0;
  std::vector<double> lifts;  // shape [targets]
  double profile_rms = 0.0;   // root mean square over the targets [px]
};

// The seed of a target on a mesh: flaps under its outline, at rest.
State GuessState(const ClothModel& model, const Observation& target, double lift);

// All scales × lifts, best first; trials that fail numerically are left out. For each scale the
// j-th candidate takes each target's j-th best lift. Fewer, or none, once *cancel is true.
// progress: share of the trials done.
std::vector<InitialGuess> RankInitialGuesses(Backend& coarse, const MaterialField& material,
                                             const std::vector<Observation>& targets,
                                             const InitialGuessOptions& options,
                                             const std::atomic<bool>* cancel,
                                             const std::function<void(double)>& progress);

}  // namespace drape
