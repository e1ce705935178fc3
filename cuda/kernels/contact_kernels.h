// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/kernels/cloth/cloth_view.h"

namespace drape {

// What obstacles do to the vertices of a batch, added to what the kernels of the cloth have written
// (physics/cloth/contact/vertex_contact.h). In a scene without obstacles nothing is launched.

// Moves vertices of x, by rollout, out of all obstacles.
void LaunchPushOut(const LaunchContext& on, double* x);

// matrix += h²·H, [9·entries] a slot; rhs += h·f unless null, [3V] a slot.
void LaunchAddContactStep(const LaunchContext& on, double h, double* matrix, double* rhs);
// force += f [N], [3V] by rollout.
void LaunchAddContactForce(const LaunchContext& on, double* force);
// sums[1] += energy [J], two numbers a slot.
void LaunchAddContactEnergy(const LaunchContext& on, double* sums);
// matrix −= ∂f/∂x, [9·entries] a slot.
void LaunchAddContactStiffness(const LaunchContext& on, double* matrix);
// blocks += ∂g/∂x, [9·num_blocks] a slot; w: by slot, [3V].
void LaunchAddContactDerivative(const LaunchContext& on, const double* w, double h, double* blocks);
// adj_x += (∂g/∂x)ᵀ·lambda, [3V] a slot.
void LaunchAddContactAdjoint(const LaunchContext& on, const double* w, double h,
                             const double* lambda, double* adj_x);

// Shortens the moves scale·direction of vertices that would enter an obstacle by shortening their
// direction, [3V] a slot. by_slot: the scale of each slot, or null where it is `scale`. blocked[s]
// is set to 1 where a move of slot s was shortened, unless null.
struct MoveScale {
  const double* by_slot;
  double scale;
};
void LaunchShortenMoves(const LaunchContext& on, MoveScale scale, double* direction, int* blocked);

}  // namespace drape
