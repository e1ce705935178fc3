// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"

namespace drape {

// block += area·[Du Dv]ᵀ·Q·[Du Dv] at corners (a, b).
__device__ __forceinline__ void AddFaceBlock(const Face& face, const FaceDerivative& derivative,
                                             int a, int b, double (&block)[9]) {
  const CornerGradient row = GradientOf(face, a), column = GradientOf(face, b);
  const double ua = face.area * row.u, va = face.area * row.v;
#pragma unroll
  for (int i = 0; i < 3; ++i)
#pragma unroll
    for (int k = 0; k < 3; ++k)
      block[3 * i + k] +=
          column.u * (ua * derivative.Q[i][k] + va * derivative.Q[3 + i][k]) +
          column.v * (ua * derivative.Q[i][3 + k] + va * derivative.Q[3 + i][3 + k]);
}

}  // namespace drape
