// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/simulation/backend.h"

namespace drape {

// The equilibrium that a cloth reaches from rest under a slowly rising load, for scenes with one
// branch (strips, clamped plates): Newton from one share of the load to the next, shorter shares
// where it fails. A share of the load is the full load on a cloth so much stiffer. `tolerance` is
// that of the full load. The last good share's result where no smaller step succeeds, with status
// kNotConverged; iterations and factorisations are those of all shares.
EquilibriumResult SolveFromRest(StepSolver& solver, const MaterialField& material,
                                const EquilibriumOptions& options);
EquilibriumResult SolveFromRest(Backend& backend, const MaterialField& material,
                                const EquilibriumOptions& options);

}  // namespace drape
