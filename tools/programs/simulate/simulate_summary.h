// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/inputs/strip_view.h"
#include "tools/programs/simulate/simulate.h"

namespace drape {

// What a simulation found out, for its summary.json.
struct SimulateSummary {
  SimulateOutcome outcome = SimulateOutcome::kDone;
  std::string status = "ok";
  std::string backend;  // Backend::name
  int steps = 0;        // done
  std::optional<int> newton_iterations;
  double force_residual = 0.0;                  // ‖f‖ / weight of the last shape
  Eigen::VectorXd lowest_eigenvalues;           // of K by mass there [s⁻²]; empty: not found
  std::optional<DrapeView> view;                // of the last shape on a support
  std::optional<StripTesterView> bench;         // of the last shape without one
  std::optional<double> gradient_disagreement;  // of adjoint and tangent, relative
  std::vector<std::pair<std::string, double>> seconds;  // by phase [s]
};

// Throws InputError when the file cannot be written.
void WriteSummary(const std::string& path, const SimulateOptions& options, const LoadedScene& scene,
                  const Camera& camera, const SimulateSummary& summary);

// "ok after 100 steps: DC 0.413, 8 folds, force residual 1.2e-05 of the weight, lowest frequency
// 0.91 Hz", or "not stable" instead of the last.
std::string SummaryLine(const SimulateSummary& summary);

}  // namespace drape
