// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/simulation/backend.h"

namespace drape {

// Computes the equilibrium that a cloth reaches from rest under a slowly rising load, for scenes
// with a single equilibrium (strips, clamped plates) [MODEL, M37]. Newton's method goes from one
// share of the load to the next, and the increment is shortened where it fails. A share of the load
// is the full load on a cloth that is stiffer by its inverse. `tolerance` refers to the full load.
// When no smaller increment succeeds, which is where a cloth loses its stability, the result of the
// last share that converged is returned with status kNotConverged and this load_share. Iterations
// and factorisations are those of all shares.
EquilibriumResult SolveFromRest(StepSolver& solver, const MaterialField& material,
                                const EquilibriumOptions& options);
EquilibriumResult SolveFromRest(Backend& backend, const MaterialField& material,
                                const EquilibriumOptions& options);

}  // namespace drape
