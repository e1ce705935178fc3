// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the kernels over elements share.

#include "cuda/device/cuda_error.h"
#include "cuda/kernels/cloth/cloth_view.h"
#include "physics/material/laws/law.h"

namespace drape {

inline int BlocksFor(int count) { return (count + kElementThreads - 1) / kElementThreads; }

// The rollout of a slot.
__device__ __forceinline__ int RolloutAt(const ShapeBatch& batch, int slot) {
  return batch.rollout == nullptr ? slot : batch.rollout[slot];
}
// A row of a matrix with `size` columns.
template <class T>
__device__ __forceinline__ T* RowAt(T* rows, int row, int size) {
  return rows + static_cast<std::int64_t>(row) * size;
}

__device__ __forceinline__ const StretchTable& StretchTableAt(const MaterialView& material,
                                                              int face) {
  return material.stretch[material.stretch_stride * face];
}
__device__ __forceinline__ const BendTable& BendTableAt(const MaterialView& material, int hinge) {
  return material.bend[material.bend_stride * hinge];
}

// The element of a thread: its slot, rollout and number, and the rollout's material and shape. A
// block of threads has a chunk of elements, chunks of faces come before chunks of hinges. Threads
// of the last chunk of each kind may be past the last element.
struct ElementThread {
  int slot, rollout;
  bool is_hinge;
  int i;
  const MaterialView& material;
  const double* x;  // [3V]
};
__device__ __forceinline__ ElementThread FindElement(const ClothView& cloth,
                                                     const ShapeBatch& batch) {
  const int face_chunks = (cloth.num_faces + kElementThreads - 1) / kElementThreads;
  const int chunk = blockIdx.x, slot = blockIdx.y, rollout = RolloutAt(batch, slot);
  const bool is_hinge = chunk >= face_chunks;
  const int first = (is_hinge ? chunk - face_chunks : chunk) * kElementThreads;
  return {slot,
          rollout,
          is_hinge,
          first + static_cast<int>(threadIdx.x),
          batch.material[rollout],
          RowAt(batch.x, rollout, cloth.num_dofs())};
}

// Launches kernel(arguments...) with a thread for each of `count` items of each slot.
template <class Kernel, class... Arguments>
void LaunchForItems(const LaunchContext& on, int count, const Kernel& kernel,
                    const Arguments&... arguments) {
  kernel<<<dim3(BlocksFor(count), on.batch.slots), kElementThreads, 0, on.stream>>>(arguments...);
  CUDA_CHECK(cudaGetLastError());
}

// Calls launch(grid, stretch law, bend law) for a grid of chunks, unless there are no elements.
template <class Launch>
void LaunchForChunks(const LaunchContext& on, const Launch& launch) {
  const int chunks = BlocksFor(on.cloth.num_faces) + BlocksFor(on.cloth.num_hinges);
  if (chunks == 0) return;
  const dim3 grid(chunks, on.batch.slots);
  std::visit([&](const auto& stretch, const auto& bend) { launch(grid, stretch, bend); },
             on.law.stretch, on.law.bend);
  CUDA_CHECK(cudaGetLastError());
}

// Writes numbers [at, at + N) of one record per thread in whole memory transactions: those of a
// warp's records go through shared memory. Called by all threads of a block; elements may be
// past the last one.
constexpr int kStageColumns = 18;
using Stage = double[kElementThreads][kStageColumns + 1];
template <int N, class Record>
__device__ __forceinline__ void StoreNumbers(const double (&value)[N], int at, Record* records,
                                             int element, int count, Stage& stage) {
  static_assert(N <= kStageColumns && sizeof(Record) % sizeof(double) == 0);
  constexpr int kNumbers = sizeof(Record) / sizeof(double);
  const int lane = threadIdx.x & 31, first = element - lane;
  const int numbers = N * min(32, count - first);
#pragma unroll
  for (int k = 0; k < N; ++k) stage[threadIdx.x][k] = value[k];
  __syncwarp();
  double* out = reinterpret_cast<double*>(records + first) + at;
  for (int i = lane; i < numbers; i += 32)
    out[i / N * kNumbers + i % N] = stage[threadIdx.x - lane + i / N][i % N];
  __syncwarp();
}

// All numbers of a record.
template <class Record, int kFrom = 0>
__device__ __forceinline__ void StoreRecord(const Record& record, Record* records, int element,
                                            int count, Stage& stage) {
  constexpr int kNumbers = sizeof(Record) / sizeof(double);
  constexpr int kPart = kNumbers - kFrom < kStageColumns ? kNumbers - kFrom : kStageColumns;
  const double* from = reinterpret_cast<const double*>(&record) + kFrom;
  double part[kPart];
#pragma unroll
  for (int k = 0; k < kPart; ++k) part[k] = from[k];
  StoreNumbers(part, kFrom, records, element, count, stage);
  if constexpr (kFrom + kPart < kNumbers)
    StoreRecord<Record, kFrom + kPart>(record, records, element, count, stage);
}

// Writes a 3×3 block of each thread of a warp to block `to` of `blocks`, nowhere where that is −1.
// Called by all threads of a warp.
__device__ __forceinline__ void StoreBlock(const double (&block)[9], double* blocks, int to,
                                           Stage& stage) {
  const int lane = threadIdx.x & 31;
#pragma unroll
  for (int k = 0; k < 9; ++k) stage[threadIdx.x][k] = block[k];
  __syncwarp();
#pragma unroll
  for (int i = lane; i < 9 * 32; i += 32) {
    const int from = i / 9, at = __shfl_sync(0xffffffffu, to, from);
    if (at >= 0) blocks[9LL * at + i % 9] = stage[threadIdx.x - lane + from][i % 9];
  }
  __syncwarp();
}

__device__ __forceinline__ Contribution Unpack(int item) {
  return {item >> 5, (item & 16) != 0, (item >> 2) & 3, item & 3};
}

// Row of Du and Dv of one corner, picked without an array that a run-time index would put in
// memory.
struct CornerGradient {
  double u, v;
};
__device__ __forceinline__ CornerGradient GradientOf(const Face& face, int corner) {
  const ShapeGradient s = GradientOf(face);
  return corner == 0   ? CornerGradient{s.u[0], s.v[0]}
         : corner == 1 ? CornerGradient{s.u[1], s.v[1]}
                       : CornerGradient{s.u[2], s.v[2]};
}

// block += area·[Du Dv]ᵀ·Q·[Du Dv] at corners (a, b).
__device__ __forceinline__ void AddFaceBlock(const Face& face, const double (&Q)[6][6], int a,
                                             int b, double (&block)[9]) {
  const CornerGradient row = GradientOf(face, a), column = GradientOf(face, b);
  const double ua = face.area * row.u, va = face.area * row.v;
#pragma unroll
  for (int i = 0; i < 3; ++i)
#pragma unroll
    for (int k = 0; k < 3; ++k)
      block[3 * i + k] += column.u * (ua * Q[i][k] + va * Q[3 + i][k]) +
                          column.v * (ua * Q[i][3 + k] + va * Q[3 + i][3 + k]);
}

__device__ __forceinline__ Vec3<double>& operator+=(Vec3<double>& a, const Vec3<double>& b) {
  a.x += b.x;
  a.y += b.y;
  a.z += b.z;
  return a;
}

}  // namespace drape
