// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "physics/util/run_control.h"
#include "solver/studies/gradients/gradient_study.h"

namespace drape {

// Where the gradients of a drape fail: differences against tangents, long horizons, and the ends of
// branches.

struct GradientSurveyOptions {
  int start_seed = 3;
  double hem_rms = 5e-3;   // of the start shape at the hem [m]
  int direction_seed = 1;  // of the line of materials
  std::vector<int> horizons = {1, 3, 10, 30, 100, 300, 1000};
  std::vector<double> time_steps = {0.02, 0.05, 0.1};  // [s]
  double horizon_step = 1e-6;                          // of the differences there
  int sweep_horizon = 50;       // of the sweep of difference steps, at h = 0.1 s
  std::string backend = "cpu";  // MakeBackend; the drapes are few and computed one by one
  int fold_starts = 6;          // branches that are followed to their ends
};

// The cloth of the study under one law.
struct StudiedCloth {
  std::string law;
  std::shared_ptr<const ClothModel> model;
  MaterialField material;
};

struct GradientSweep {
  std::string name;  // "smooth, 50 steps"
  std::vector<GradientError> errors;
};
struct HorizonSeries {
  std::string law;
  double h = 0.0;
  std::vector<int> horizons;          // those done
  std::vector<GradientError> errors;  // one of each
};
struct FollowedBranch {
  int seed = 0;
  ContinuationResult path;
  std::optional<FoldApproach> approach;
};
struct GradientStudy {
  bool cancelled = false;
  std::vector<GradientSweep> sweeps;
  std::vector<HorizonSeries> horizons;
  std::vector<FollowedBranch> branches;
  std::string note;  // on what its report lacks, with an end of line; empty: nothing
};

// cloths: at least one; branches are followed on the first. A cancelled study has what is complete.
GradientStudy SurveyGradients(std::span<const StudiedCloth> cloths,
                              const GradientSurveyOptions& options, const RunControl& control);

}  // namespace drape
