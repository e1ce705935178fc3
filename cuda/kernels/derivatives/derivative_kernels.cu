// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/element_kernels.h"
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
                         const double* all_w, double h, DerivativeRecords all_records) {
  __shared__ Stage stage;
  const ElementThread at = FindElement(cloth, batch);
  const DerivativeRecords records = all_records.From(cloth, at.slot);
  const double* w = RowAt(all_w, at.slot, cloth.num_dofs());
  if (!at.is_hinge) {
    const int f = min(at.i, cloth.num_faces - 1);
    FaceDerivative record;
    StretchStepDerivative(stretch, GatherColumns(cloth.faces[f], at.x),
                          StretchTableAt(at.material, f), GatherColumns(cloth.faces[f], w), h,
                          record.Q);
    StoreRecord(record, records.faces, at.i, cloth.num_faces, stage);
  } else {
    const int e = min(at.i, cloth.num_hinges - 1);
    StoreBlocks(EvaluateBendStepRates(bend, cloth.hinges[e], BendTableAt(at.material, e),
                                      GatherCorners(cloth.hinges[e], at.x),
                                      GatherCorners(cloth.hinges[e], w), h),
                records.hinges, at.i, cloth.num_hinges, stage);
  }
}

// Blocks (i, j) and (j, i) at once.
__global__ void __launch_bounds__(kElementThreads)
    GatherDerivative(ClothView cloth, DerivativeRecords all_records, double h, double* all_blocks) {
  const int item = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (item >= cloth.num_entries) return;
  const int entry = cloth.entry_order[item];
  const DerivativeRecords records = all_records.From(cloth, slot);
  double lower[9] = {}, upper[9] = {};
  for (int k = cloth.to_entry.start[entry]; k < cloth.to_entry.start[entry + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_entry.item[k]);
    if (c.hinge) {
      const double* at_ab = records.hinges[c.element].block[c.row][c.column];
      const double* at_ba = records.hinges[c.element].block[c.column][c.row];
#pragma unroll
      for (int n = 0; n < 9; ++n) {
        lower[n] += at_ab[n];
        upper[n] += at_ba[n];
      }
    } else {
      AddFaceBlock(cloth.faces[c.element], records.faces[c.element].Q, c.row, c.column, lower);
      AddFaceBlock(cloth.faces[c.element], records.faces[c.element].Q, c.column, c.row, upper);
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
                      FactorRecords all_records) {
  __shared__ Stage stage;
  const ElementThread at = FindElement(cloth, batch);
  const MaterialView& weight = weights[at.rollout];
  const FactorRecords records = all_records.From(cloth, at.slot);
  const double* w = RowAt(all_w, at.slot, cloth.num_dofs());
  if (!at.is_hinge) {
    const int f = min(at.i, cloth.num_faces - 1);
    const FaceSensitivity s =
        EvaluateSensitivity(stretch, cloth.faces[f], StretchTableAt(at.material, f), at.x, w, h);
    const StretchTable& scale = StretchTableAt(weight, f);
    FaceFactors record;
    for (int m = 0; m < kStretchCols; ++m) record.basis[m] = s.basis[m];
    for (int r = 0; r < kStretchRows; ++r)
      for (int m = 0; m < kStretchCols; ++m)
        record.factor[kStretchCols * r + m] = s.by_entry[r][m] * scale.c[r][m];
    StoreRecord(record, records.faces, at.i, cloth.num_faces, stage);
  } else {
    const int e = min(at.i, cloth.num_hinges - 1);
    const HingeSensitivity s =
        EvaluateSensitivity(bend, cloth.hinges[e], BendTableAt(at.material, e), at.x, w, h);
    const BendTable& scale = BendTableAt(weight, e);
    HingeFactors record;
    record.basis = s.basis;
    for (int r = 0; r < kBendRows; ++r)
      for (int c = 0; c < kBendCols; ++c)
        record.factor[kBendCols * r + c] = s.by_entry[r][c] * scale.b[r][c];
    StoreRecord(record, records.hinges, at.i, cloth.num_hinges, stage);
  }
}

__global__ void DampVelocity(ShapeBatch batch, const double* w, double h, double* damped,
                             int dofs) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i >= dofs) return;
  const std::int64_t at = static_cast<std::int64_t>(slot) * dofs + i;
  damped[at] = (1.0 + batch.material[RolloutAt(batch, slot)].stiffness_damping / h) * w[at];
}

}  // namespace

void LaunchDampVelocity(const LaunchContext& on, const double* w, double h, double* damped) {
  LaunchForItems(on, on.cloth.num_dofs(), DampVelocity, on.batch, w, h, damped,
                 on.cloth.num_dofs());
}

void LaunchDerivativeRecords(const LaunchContext& on, const double* w, double h,
                             const DerivativeRecords& records) {
  LaunchForChunks(on, [&](dim3 grid, const auto& stretch, const auto& bend) {
    DerivativeOfElements<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch, bend,
                                                                  w, h, records);
  });
}

void LaunchGatherDerivative(const LaunchContext& on, const DerivativeRecords& records,
                            const double* w, double h, double* blocks) {
  LaunchForItems(on, on.cloth.num_entries, GatherDerivative, on.cloth, records, h, blocks);
  LaunchAddContactDerivative(on, w, h, blocks);
}

void LaunchFactorRecords(const LaunchContext& on, const MaterialView* weight, const double* w,
                         double h, const FactorRecords& records) {
  LaunchForChunks(on, [&](dim3 grid, const auto& stretch, const auto& bend) {
    FactorsOfElements<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch, bend,
                                                               weight, w, h, records);
  });
}

}  // namespace drape
