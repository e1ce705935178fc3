// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/material/material.h"
#include "physics/simulation/backend.h"
#include "solver/fit/observed/observation.h"
#include "solver/forward/settle.h"

namespace drape {

// Guided drapes find a drape near what was observed among the many drapes of a material [METHODS,
// P58]: while the cloth falls it is pulled towards the measurements, then released.

// How far each vertex is to be displaced for a shape x to have the readings that were measured [m],
// shape [3V]: the least squares over the numbers that see the vertex, as if its neighbours came
// along. Between these vertices and those that are held it is harmonic. Zero for a sight that reads
// the material, or cannot read the shape. sight: of one run.
Eigen::VectorXd DisplacementTo(const ClothModel& model, const Sight& sight,
                               const Eigen::VectorXd& x);

// Settles a start under a material as Settle does, towards an observation: with the first of
// options.steps under its pull.
SettledDrape SettleGuided(Backend& backend, const MaterialField& material, const State& start,
                          const Observation& observation, const SettleOptions& options);

}  // namespace drape
