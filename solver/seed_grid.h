// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "physics/backend.h"
#include "solver/target.h"

namespace drape {

// Which materials and seed shapes are tried, on a coarse cloth (SPEC section 5).
struct SeedGridOptions {
  std::vector<double> stretch = {1.0, 4.0, 16.0};  // factors on all stretch entries
  std::vector<double> bend = {0.06, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0};  // on all bend entries
  std::vector<double> lifts = {0.3, 0.6, 0.8, 1.0};  // of FlapsFromOutline
  double h = 0.1;                                  // time step [s]
  int steps = 60;                                  // of each trial
};

// A material scale and a seed for each target, and how near its coarse drapes come.
struct SeedCandidate {
  double stretch = 1.0;
  double bend = 1.0;
  std::vector<double> lifts;  // shape [targets]
  double profile_rms = 0.0;   // root mean square over the targets [px]
};
