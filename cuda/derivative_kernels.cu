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
  __shared__ Stage stage;
  const int slot = blockIdx.y, rollout = RolloutOf(batch, slot);
  const MaterialView& material = batch.material[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  const Chunk chunk = ChunkOf(cloth);
  const int i = chunk.first + threadIdx.x;
  if (!chunk.hinges) {
    const int f = min(i, cloth.num_faces - 1);
    FaceDerivative record;
    StretchStepDerivative(stretch, GatherColumns(cloth.faces[f], x), StretchOf(material, f),
                          GatherColumns(cloth.faces[f], w), h, record.Q);
    StoreRecord(record, records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces, i,
                cloth.num_faces, stage);
  } else {
    const int e = min(i, cloth.num_hinges - 1);
    const BendStepRates record =
        EvaluateBendStepRates(bend, cloth.hinges[e], BendOf(material, e),
                              GatherCorners(cloth.hinges[e], x), GatherCorners(cloth.hinges[e], w),
                              h);
    StoreRecord(record, records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges, i,
                cloth.num_hinges, stage);
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

// Blocks (i, j) and (j, i) at once: the Hessians of the angles are symmetric.
__global__ void __launch_bounds__(kElementThreads)
    GatherDerivative(ClothView cloth, DerivativeRecords records, double h, double* all_blocks) {
  const int entry = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (entry >= cloth.num_entries) return;
  const FaceDerivative* faces = records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces;
  const BendStepRates* hinges =
      records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges;
  double lower[9] = {}, upper[9] = {};
  for (int k = cloth.to_entry.start[entry]; k < cloth.to_entry.start[entry + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_entry.item[k]);
    if (c.hinge) {
      AddBendStepBlocks(hinges[c.element], c.row, c.column, lower, upper);
    } else {
      AddFaceBlock(cloth.faces[c.element], faces[c.element], c.row, c.column, lower);
      AddFaceBlock(cloth.faces[c.element], faces[c.element], c.column, c.row, upper);
    }
  }
  const int b = cloth.entry_block[entry], mirror = cloth.mirror[b];
  if (mirror == b) {
    const double handle = h * cloth.handle[cloth.column[b]];
    for (int r = 0; r < 9; r += 4) lower[r] -= handle;
  }
  double* blocks = all_blocks + 9LL * slot * cloth.num_blocks;
#pragma unroll
  for (int n = 0; n < 9; ++n) blocks[9LL * b + n] = lower[n];
  if (mirror == b) return;
#pragma unroll
  for (int n = 0; n < 9; ++n) blocks[9LL * mirror + n] = upper[n];
}

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    FactorsOfElements(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                      const MaterialView* weights, const double* all_w, double h,
                      FactorRecords records) {
  __shared__ Stage stage;
  const int slot = blockIdx.y, rollout = RolloutOf(batch, slot);
  const MaterialView &material = batch.material[rollout], &weight = weights[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  const Chunk chunk = ChunkOf(cloth);
  const int i = chunk.first + threadIdx.x;
  if (!chunk.hinges) {
    const int f = min(i, cloth.num_faces - 1);
    const FaceSensitivity s =
        EvaluateSensitivity(stretch, cloth.faces[f], StretchOf(material, f), x, w, h);
    const StretchTable& scale = StretchOf(weight, f);
    FaceFactors record;
    for (int m = 0; m < kStretchCols; ++m) record.basis[m] = s.basis[m];
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m)
        record.factor[kStretchCols * r + m] = s.by_entry[r][m] * scale.c[r][m];
    StoreRecord(record, records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces, i,
                cloth.num_faces, stage);
  } else {
    const int e = min(i, cloth.num_hinges - 1);
    const HingeSensitivity s =
        EvaluateSensitivity(bend, cloth.hinges[e], BendOf(material, e), x, w, h);
    const BendTable& scale = BendOf(weight, e);
    HingeFactors record;
    record.basis = s.basis;
    for (int r = 0; r < kBendRows; ++r)
      for (int c = 0; c < kBendCols; ++c)
        record.factor[kBendCols * r + c] = s.by_entry[r][c] * scale.b[r][c];
    StoreRecord(record, records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges, i,
                cloth.num_hinges, stage);
  }
}

}  // namespace

void LaunchDerivativeRecords(const ClothView& cloth, const ShapeBatch& batch, const Law& law,
                             const double* w, double h, const DerivativeRecords& records,
                             cudaStream_t stream) {
  const dim3 grid(ChunksFor(cloth), batch.slots);
  if (grid.x == 0) return;
  std::visit([&](const auto& stretch, const auto& bend) {
    DerivativeOfElements<<<grid, kElementThreads, 0, stream>>>(cloth, batch, stretch, bend, w, h,
                                                                records);
  }, law.stretch, law.bend);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchGatherDerivative(const ClothView& cloth, const DerivativeRecords& records, double h,
                            double* blocks, int slots, cudaStream_t stream) {
  GatherDerivative<<<dim3(BlocksFor(cloth.num_entries), slots), kElementThreads, 0, stream>>>(
      cloth, records, h, blocks);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchFactorRecords(const ClothView& cloth, const ShapeBatch& batch, const Law& law,
                         const MaterialView* weight, const double* w, double h,
                         const FactorRecords& records, cudaStream_t stream) {
  const dim3 grid(ChunksFor(cloth), batch.slots);
  if (grid.x == 0) return;
  std::visit([&](const auto& stretch, const auto& bend) {
    FactorsOfElements<<<grid, kElementThreads, 0, stream>>>(cloth, batch, stretch, bend, weight, w,
                                                             h, records);
  }, law.stretch, law.bend);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
