// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solver/job/fit_job.h"

namespace drape {

// The inputs of a job, read and checked, with the backends that the problem points to.
struct LoadedJob {
  std::shared_ptr<const ClothModel> fine_model;
  std::unique_ptr<Backend> fine, coarse;
  std::string backend_choice;  // empty: tests alone, without a backend
  FitProblem problem;
  StagedFitOptions fit;
  std::unique_ptr<StripResiduals> tests;
  std::optional<FitSummary> tests_alone;
  std::unique_ptr<MaterialField> truth;
  std::vector<std::string> notes;
};

// Throws InputError for a file, a name or a combination that cannot be fitted.
LoadedJob LoadJob(const FitJob& job);

// What must be the same for a checkpoint to be continued: all that the fit of one table follows
// from, which is the same for all models.
std::string CheckpointKey(const FitJob& job, const LoadedJob& loaded);

}  // namespace drape
