// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the kernels over elements share.

#include "cuda/kernels/cloth/cloth_view.h"
#include "physics/material/laws/law.h"

namespace drape {

inline int BlocksFor(int count) { return (count + kElementThreads - 1) / kElementThreads; }

// The rollout of a slot.
__device__ __forceinline__ int RolloutAt(const ShapeBatch& batch, int slot) {
  return batch.rollout == nullptr ? slot : batch.rollout[slot];
}
__device__ __forceinline__ const double* NodesOf(const double* nodes, int index, int num_dofs) {
  return nodes + static_cast<std::int64_t>(index) * num_dofs;
}
__device__ __forceinline__ double* NodesOf(double* nodes, int index, int num_dofs) {
  return nodes + static_cast<std::int64_t>(index) * num_dofs;
}

__device__ __forceinline__ const StretchTable& StretchTableAt(const MaterialView& material,
                                                              int face) {
  return material.stretch[material.stretch_stride * face];
}
__device__ __forceinline__ const BendTable& BendTableAt(const MaterialView& material, int hinge) {
  return material.bend[material.bend_stride * hinge];
}

// Chunks of elements: a block of threads has one, those of faces before those of hinges.
struct Chunk {
  bool hinges;
  int first;  // element
};
__device__ __forceinline__ Chunk FindChunk(const ClothView& cloth) {
  const int face_chunks = (cloth.num_faces + kElementThreads - 1) / kElementThreads;
  const int chunk = blockIdx.x;
  return chunk < face_chunks ? Chunk{false, chunk * kElementThreads}
                             : Chunk{true, (chunk - face_chunks) * kElementThreads};
}
inline int ChunksFor(const ClothView& cloth) {
  return BlocksFor(cloth.num_faces) + BlocksFor(cloth.num_hinges);
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

__device__ __forceinline__ Vec3<double>& operator+=(Vec3<double>& a, const Vec3<double>& b) {
  a.x += b.x;
  a.y += b.y;
  a.z += b.z;
  return a;
}

}  // namespace drape
