// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/programs/simulate/simulate_result.h"

namespace drape {

// Throws InputError when the file cannot be written.
void WriteSummary(const std::string& path, const SimulateOptions& options, const LoadedScene& scene,
                  const Camera& camera, const SimulateResult& result);

// "ok after 100 steps: DC 0.413, 8 folds, force residual 1.2e-05 of the weight, lowest frequency
// 0.91 Hz", or "not stable" instead of the last.
std::string SummaryLine(const SimulateResult& result);

}  // namespace drape
