// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the kernels over elements share.

#include "cuda/cloth_view.h"
#include "physics/law.h"

namespace drape {

constexpr int kElementThreads = 128;

inline int BlocksFor(int count) { return (count + kElementThreads - 1) / kElementThreads; }

// The rollout of a slot.
__device__ __forceinline__ int RolloutOf(const ShapeBatch& batch, int slot) {
  return batch.rollout == nullptr ? slot : batch.rollout[slot];
}
__device__ __forceinline__ const double* NodesOf(const double* nodes, int index, int num_dofs) {
  return nodes + static_cast<std::int64_t>(index) * num_dofs;
}
__device__ __forceinline__ double* NodesOf(double* nodes, int index, int num_dofs) {
  return nodes + static_cast<std::int64_t>(index) * num_dofs;
}

__device__ __forceinline__ const StretchTable& StretchOf(const MaterialView& material, int face) {
  return material.stretch[material.stretch_stride * face];
}
__device__ __forceinline__ const BendTable& BendOf(const MaterialView& material, int hinge) {
  return material.bend[material.bend_stride * hinge];
}

__device__ __forceinline__ Contribution Unpack(int item) {
  return {item >> 5, (item & 16) != 0, (item >> 2) & 3, item & 3};
}

// Row of Du and Dv of one corner, picked without an array that a run-time index would put in memory.
struct CornerGradient {
  double u, v;
};
__device__ __forceinline__ CornerGradient GradientOf(const Face& face, int corner) {
  const ShapeGradient s = GradientOf(face);
  return corner == 0 ? CornerGradient{s.u[0], s.v[0]}
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
