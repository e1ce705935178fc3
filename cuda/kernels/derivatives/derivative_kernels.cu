// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_error.h"
#include "cuda/kernels/contact_kernels.h"
#include "cuda/kernels/derivatives/derivative_blocks.cuh"
#include "physics/material/laws/element_sensitivity.h"

namespace drape {
namespace {

// Two blocks at a time, which lie together.
__device__ void StoreBlocks(const BendStepRates& rates, HingeDerivative* records, int element,
                            int count, Stage& stage) {
#pragma unroll
  for (int pair = 0; pair < 8; ++pair) {
    const int a = pair / 2, b = 2 * (pair % 2);
    double blocks[18] = {}, transposed[9] = {};
    double(&left)[9] = *reinterpret_cast<double(*)[9]>(blocks);
    double(&right)[9] = *reinterpret_cast<double(*)[9]>(blocks + 9);
    AddBendStepBlocks(rates, a, b, left, transposed);
    AddBendStepBlocks(rates, a, b + 1, right, transposed);
    StoreNumbers(blocks, 18 * pair, records, element, count, stage);
  }
}

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    DerivativeOfElements(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                         const double* all_w, double h, DerivativeRecords records) {
  __shared__ Stage stage;
  const int slot = blockIdx.y, rollout = RolloutAt(batch, slot);
  const MaterialView& material = batch.material[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  const Chunk chunk = FindChunk(cloth);
  const int i = chunk.first + threadIdx.x;
  if (!chunk.hinges) {
    const int f = min(i, cloth.num_faces - 1);
    FaceDerivative record;
    StretchStepDerivative(stretch, GatherColumns(cloth.faces[f], x), StretchTableAt(material, f),
                          GatherColumns(cloth.faces[f], w), h, record.Q);
    StoreRecord(record, records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces, i,
                cloth.num_faces, stage);
  } else {
    const int e = min(i, cloth.num_hinges - 1);
    StoreBlocks(EvaluateBendStepRates(bend, cloth.hinges[e], BendTableAt(material, e),
                                      GatherCorners(cloth.hinges[e], x),
                                      GatherCorners(cloth.hinges[e], w), h),
                records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges, i,
                cloth.num_hinges, stage);
  }
}

// Blocks (i, j) and (j, i) at once.
__global__ void __launch_bounds__(kElementThreads)
    GatherDerivative(ClothView cloth, DerivativeRecords records, double h, double* all_blocks) {
  const int item = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (item >= cloth.num_entries) return;
  const int entry = cloth.entry_order[item];
  const FaceDerivative* faces = records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces;
  const HingeDerivative* hinges =
      records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges;
  double lower[9] = {}, upper[9] = {};
  for (int k = cloth.to_entry.start[entry]; k < cloth.to_entry.start[entry + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_entry.item[k]);
    if (c.hinge) {
      const double* at_ab = hinges[c.element].block[c.row][c.column];
      const double* at_ba = hinges[c.element].block[c.column][c.row];
#pragma unroll
      for (int n = 0; n < 9; ++n) {
        lower[n] += at_ab[n];
        upper[n] += at_ba[n];
      }
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
  const int slot = blockIdx.y, rollout = RolloutAt(batch, slot);
  const MaterialView &material = batch.material[rollout], &weight = weights[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  const Chunk chunk = FindChunk(cloth);
  const int i = chunk.first + threadIdx.x;
  if (!chunk.hinges) {
    const int f = min(i, cloth.num_faces - 1);
    const FaceSensitivity s =
        EvaluateSensitivity(stretch, cloth.faces[f], StretchTableAt(material, f), x, w, h);
    const StretchTable& scale = StretchTableAt(weight, f);
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
        EvaluateSensitivity(bend, cloth.hinges[e], BendTableAt(material, e), x, w, h);
    const BendTable& scale = BendTableAt(weight, e);
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

void LaunchDerivativeRecords(const LaunchContext& on, const double* w, double h,
                             const DerivativeRecords& records) {
  const dim3 grid(ChunksFor(on.cloth), on.batch.slots);
  if (grid.x == 0) return;
  std::visit(
      [&](const auto& stretch, const auto& bend) {
        DerivativeOfElements<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch,
                                                                      bend, w, h, records);
      },
      on.law.stretch, on.law.bend);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchGatherDerivative(const LaunchContext& on, const DerivativeRecords& records,
                            const double* w, double h, double* blocks) {
  GatherDerivative<<<dim3(BlocksFor(on.cloth.num_entries), on.batch.slots), kElementThreads, 0,
                     on.stream>>>(on.cloth, records, h, blocks);
  CUDA_CHECK(cudaGetLastError());
  LaunchAddContactDerivative(on, w, h, blocks);
}

void LaunchFactorRecords(const LaunchContext& on, const MaterialView* weight, const double* w,
                         double h, const FactorRecords& records) {
  const dim3 grid(ChunksFor(on.cloth), on.batch.slots);
  if (grid.x == 0) return;
  std::visit(
      [&](const auto& stretch, const auto& bend) {
        FactorsOfElements<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch,
                                                                   bend, weight, w, h, records);
      },
      on.law.stretch, on.law.bend);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
