// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/engine/resources/step_workspace.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"

namespace drape {

// Workspace of the adjoint pass through recorded rollouts by slot.
struct AdjointWorkspace {
  StepWorkspace step;     // x: of the present step; v: its end
  AdjointRecords single;  // for one column; for more:
  DerivativeRecords derivatives;
  double* blocks;                  // [9·num_blocks] a slot
  double *adj_x, *adj_v, *lambda;  // [3V, columns]
  double* vectors;                 // [vector_size, columns]

  static AdjointWorkspace Take(Arena& arena, const DeviceCloth& cloth, int slots, int columns) {
    const std::size_t n = slots;
    const ClothView& view = cloth.view();
    AdjointWorkspace w{};
    w.step = StepWorkspace::Take(arena, cloth, slots);
    if (columns == 1) {
      w.single = {arena.Take<DeformationGradient<double>>(n * view.num_faces),
                  arena.Take<BendAdjoint>(n * view.num_hinges)};
    } else {
      w.derivatives = {arena.Take<FaceDerivative>(n * view.num_faces),
                       arena.Take<HingeDerivative>(n * view.num_hinges)};
      w.blocks = arena.Take<double>(n * 9 * view.num_blocks);
    }
    w.vectors = arena.Take<double>(n * cloth.multifrontal().view().vector_size * columns);
    w.adj_x = arena.Take<double>(n * view.num_dofs() * columns);
    w.adj_v = arena.Take<double>(n * view.num_dofs() * columns);
    w.lambda = arena.Take<double>(n * view.num_dofs() * columns);
    return w;
  }
};

}  // namespace drape
