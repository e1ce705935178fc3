// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "physics/cloth/contact/surface_contact.h"

namespace drape {

// Steps that no pair of surfaces crosses on the straight way, by continuous collision detection.
// A step is free if no pair comes nearer than a tenth of its gap.

// Returns whether the step dx of the cloth from x is free while obstacles move from the start of
// their step to its end.
bool IsStepFree(SurfaceContact& surfaces, const Eigen::VectorXd& x, const Eigen::VectorXd& dx);
// Changes dx to a step that is free while obstacles move, in parts of the step [MODEL, M63].
// Returns a vertex of the cloth that stays in the way if there is none.
std::optional<int> FindFreeStep(SurfaceContact& surfaces, const Eigen::VectorXd& x,
                                Eigen::VectorXd& dx);
// Shortens the moves dx of single vertices at x to a free step, with obstacles at the end of their
// step. Returns whether it has shortened one.
bool LimitStep(SurfaceContact& surfaces, const Eigen::VectorXd& x, Eigen::VectorXd& dx);

}  // namespace drape
