// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "physics/simulation/backend.h"

namespace drape {

// Calls of Backend in terms of its other calls, for backends that do not implement them natively:
// the readout is evaluated on the threads of the host.

// ReadoutTangents from Tangents.
std::vector<ReadoutTangent> ReadTangents(Backend& backend, std::span<const RolloutInput> batch,
                                         std::span<const MaterialField* const> weights,
                                         const RolloutOptions& options, const Readout& readout);
// LossGradients from Rollouts and Adjoints.
std::vector<LossGradient> DifferentiateLosses(Backend& backend, std::span<const RolloutInput> batch,
                                              const RolloutOptions& options,
                                              const ReadoutLoss& loss);
// EquilibriumJvp from the 39 columns of EquilibriumTangents: the sum of the weighted columns. For
// fakes and for comparisons; it costs 39 solves for one.
std::vector<Eigen::VectorXd> SumEquilibriumTangents(Backend& backend,
                                                    std::span<const RolloutInput> batch,
                                                    std::span<const MaterialField* const> changes);
// EquilibriumReadoutTangents from EquilibriumTangents.
std::vector<LinearReadout> ReadEquilibriumTangents(Backend& backend,
                                                   std::span<const RolloutInput> batch,
                                                   std::span<const MaterialField* const> weights,
                                                   const Readout& readout);

}  // namespace drape
