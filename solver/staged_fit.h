// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "physics/backend.h"
#include "solver/fit.h"
#include "solver/seed_grid.h"
#include "solver/target.h"

namespace drape {

// The protocol of SPEC section 5 for one material and its images. Many drapes are stable and the
// trust region stays in its basin, so: (1) a grid of stretch × bend factors × seed shapes on a
// coarse cloth, ranked by outline; (2) the best few settled on the fine cloth and fitted by Ceres,
// each on its own branch; (3) the winner's drape seeded anew with the fitted material, kept where
// it is better; (4) the last fit from there.
struct StagedFitOptions {
  SeedGridOptions grid;
  int candidates = 4;            // of the grid, fitted each
  int candidate_iterations = 12;
  int reseed_rounds = 1;         // stages 3 and 4 again
  int final_iterations = 20;
  Tying parameters = Tying::kEntries;
  double prior_sigma = 1.0;      // of each log factor about the winner's start
  double sigma_px = 0.5;         // standard deviation of r(θ) [px]
  int angles = 90;               // K of r(θ)
  double settle_h = 0.1;         // steps that calm a seed before Newton [s]
  int settle_steps = 40;
  Integrator integrator = Integrator::kStatic;
  const std::atomic<bool>* cancel = nullptr;

  void Check() const;  // programmer errors
};

// Work done, for a progress line: a stage's name and the share of all work.
struct StageProgress {
  std::string stage;
  double fraction = 0.0;
  double profile_rms = 0.0;  // best so far [px]; 0 when not known
};
