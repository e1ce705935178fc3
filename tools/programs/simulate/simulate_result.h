// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "solver/forward/simulation.h"
#include "tools/inputs/drape_view.h"
#include "tools/inputs/strip_view.h"

namespace drape {

// What drape_simulate found, for its summary.
struct SimulateResult {
  SimulationResult simulation;
  std::string backend;                   // Backend::name
  double force_residual = 0.0;           // ‖f‖ / weight of the last shape
  Eigen::VectorXd lowest_eigenvalues;    // of K by mass there [s⁻²]; empty: not found
  std::optional<DrapeView> view;         // of the last shape on a support
  std::optional<StripTesterView> bench;  // of the last shape without one
  std::string line;                      // the drape in one line, for a person
};

}  // namespace drape
