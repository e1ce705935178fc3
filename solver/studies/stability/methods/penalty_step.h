// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "physics/cloth/contact/contact.h"
#include "solver/studies/stability/methods/integrator.h"

namespace drape {

struct PenaltyOptions {
  double stiffness = 1e6;  // of the springs, by area of the cloth [Pa/m]
  double friction = 0.0;   // μ
};

// The one-solve step with the usual cheap contact, for the atlas alone: a vertex that is inside of
// an obstacle at the begin of a step is pushed out of it by a spring, implicitly along the normal,
// with Coulomb's friction by the momentum of that push. Nothing sees what happens within a step.
// The scene of the model has no contact; that of `contact`, which outlives the object, may change
// between steps.
std::unique_ptr<Integrator> MakePenaltyStep(std::shared_ptr<const ClothModel> model,
                                            const MaterialField& material, double h,
                                            const Contact* contact, const PenaltyOptions& options);

}  // namespace drape
