// SPDX-License-Identifier: Apache-2.0
#include "cuda/cuda_error.h"
#include "cuda/element_kernels.cuh"
#include "cuda/sensitivity_kernels.h"
#include "physics/element_sensitivity.h"

namespace drape {
namespace {

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    DerivativeOfElements(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                         const double* all_w, double h, DerivativeRecords records) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  const int rollout = RolloutOf(batch, slot);
  const MaterialView& material = batch.material[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  if (i < cloth.num_faces) {
    double Q[6][6];
    StretchStepDerivative(stretch, GatherColumns(cloth.faces[i], x), StretchOf(material, i),
                          GatherColumns(cloth.faces[i], w), h, Q);
    FaceDerivative& to = records.faces[static_cast<std::int64_t>(slot) * cloth.num_faces + i];
    for (int r = 0; r < 6; ++r)
      for (int c = 0; c < 6; ++c) to.Q[r][c] = Q[r][c];
  } else if (const int e = i - cloth.num_faces; e < cloth.num_hinges) {
    records.hinges[static_cast<std::int64_t>(slot) * cloth.num_hinges + e] =
        EvaluateBendStepRates(bend, cloth.hinges[e], BendOf(material, e),
                              GatherCorners(cloth.hinges[e], x), GatherCorners(cloth.hinges[e], w),
                              h);
  }
}

// block += area·[Du Dv]ᵀ·Q·[Du Dv] at corners (a, b).
__device__ void AddFaceBlock(const Face& face, const FaceDerivative& derivative, int a, int b,
                             double (&block)[9]) {
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

__global__ void __launch_bounds__(kElementThreads)
    GatherDerivative(ClothView cloth, DerivativeRecords records, double h, double* all_blocks) {
  const int b = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (b >= cloth.num_blocks) return;
  const FaceDerivative* faces = records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces;
  const BendStepRates* hinges =
      records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges;
  double block[9] = {};
  for (int k = cloth.to_block.start[b]; k < cloth.to_block.start[b + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_block.item[k]);
    if (c.hinge) {
      AddBendStepBlock(hinges[c.element], c.row, c.column, block);
    } else {
      AddFaceBlock(cloth.faces[c.element], faces[c.element], c.row, c.column, block);
    }
  }
  if (cloth.mirror[b] == b) {
    const double handle = h * cloth.handle[cloth.column[b]];
    for (int r = 0; r < 9; r += 4) block[r] -= handle;
  }
  double* to = all_blocks + 9 * (static_cast<std::int64_t>(slot) * cloth.num_blocks + b);
#pragma unroll
  for (int n = 0; n < 9; ++n) to[n] = block[n];
}

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    FactorsOfElements(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                      const MaterialView* weights, const double* all_w, double h,
                      FactorRecords records) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  const int rollout = RolloutOf(batch, slot);
  const MaterialView &material = batch.material[rollout], &weight = weights[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  if (i < cloth.num_faces) {
    const FaceSensitivity s =
        EvaluateSensitivity(stretch, cloth.faces[i], StretchOf(material, i), x, w, h);
    FaceFactors& to = records.faces[static_cast<std::int64_t>(slot) * cloth.num_faces + i];
    const StretchTable& scale = StretchOf(weight, i);
    for (int m = 0; m < kStretchCols; ++m) to.basis[m] = s.basis[m];
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m)
        to.factor[kStretchCols * r + m] = s.by_entry[r][m] * scale.c[r][m];
  } else if (const int e = i - cloth.num_faces; e < cloth.num_hinges) {
    const HingeSensitivity s =
        EvaluateSensitivity(bend, cloth.hinges[e], BendOf(material, e), x, w, h);
    HingeFactors& to = records.hinges[static_cast<std::int64_t>(slot) * cloth.num_hinges + e];
    const BendTable& scale = BendOf(weight, e);
    to.basis = s.basis;
    for (int r = 0; r < kBendRows; ++r)
      for (int c = 0; c < kBendCols; ++c)
        to.factor[kBendCols * r + c] = s.by_entry[r][c] * scale.b[r][c];
  }
}

}  // namespace

void LaunchDerivativeRecords(const ClothView& cloth, const ShapeBatch& batch, const Law& law,
                             const double* w, double h, const DerivativeRecords& records,
                             cudaStream_t stream) {
  const dim3 grid(BlocksFor(cloth.num_faces + cloth.num_hinges), batch.slots);
  std::visit([&](const auto& stretch, const auto& bend) {
    DerivativeOfElements<<<grid, kElementThreads, 0, stream>>>(cloth, batch, stretch, bend, w, h,
                                                                records);
  }, law.stretch, law.bend);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchGatherDerivative(const ClothView& cloth, const DerivativeRecords& records, double h,
                            double* blocks, int slots, cudaStream_t stream) {
  GatherDerivative<<<dim3(BlocksFor(cloth.num_blocks), slots), kElementThreads, 0, stream>>>(
      cloth, records, h, blocks);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchFactorRecords(const ClothView& cloth, const ShapeBatch& batch, const Law& law,
                         const MaterialView* weight, const double* w, double h,
                         const FactorRecords& records, cudaStream_t stream) {
  const dim3 grid(BlocksFor(cloth.num_faces + cloth.num_hinges), batch.slots);
  std::visit([&](const auto& stretch, const auto& bend) {
    FactorsOfElements<<<grid, kElementThreads, 0, stream>>>(cloth, batch, stretch, bend, weight, w,
                                                             h, records);
  }, law.stretch, law.bend);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
