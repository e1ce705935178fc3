// SPDX-License-Identifier: Apache-2.0
// Gradients of m scalars by the material tables: a thread has one element, a block a chunk of them.
#include "cuda/device/cuda_error.h"
#include "cuda/kernels/derivatives/gradient_sums.cuh"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"
#include "physics/material/laws/element_sensitivity.h"

namespace drape {
namespace {

// λ·basis of each column of the tables, for right-hand side j.
__device__ void AlongBasis(const Face& face, const FaceSensitivity& s, const double* lambda,
                           int columns, double (&along)[kStretchCols]) {
  const ShapeGradient shape = GradientOf(face);
#pragma unroll
  for (int m = 0; m < kStretchCols; ++m) along[m] = 0.0;
#pragma unroll
  for (int a = 0; a < 3; ++a) {
    const double* at = lambda + 3LL * face.vertex[a] * columns;
    const Vec3<double> l{at[0], at[columns], at[2 * columns]};
#pragma unroll
    for (int m = 0; m < kStretchCols; ++m)
      along[m] += shape.u[a] * Dot(s.basis[m].u, l) + shape.v[a] * Dot(s.basis[m].v, l);
  }
}

template <class Law>
__device__ void FaceGradient(const ClothView& cloth, const MaterialView& material, const Law& law,
                             const double* x, const double* w, double h, const double* lambda,
                             int columns, int chunk, double* gradient) {
  __shared__ double scratch[kGradientWarps][kStretchEntries];
  const int f = chunk * kGradientChunk + threadIdx.x;
  const bool acts = f < cloth.num_faces;
  const Face& face = cloth.faces[acts ? f : 0];
  const FaceSensitivity s =
      EvaluateSensitivity(law, face, StretchTableAt(material, acts ? f : 0), x, w, h);
  const int row = material.stretch_stride != 0 ? f : chunk;
  for (int j = 0; j < columns; ++j) {
    double along[kStretchCols], by_entry[kStretchEntries];
    AlongBasis(face, s, lambda + j, columns, along);
#pragma unroll
    for (int k = 0; k < kStretchEntries; ++k)
      by_entry[k] =
          acts ? s.by_entry[k / kStretchCols][k % kStretchCols] * along[k % kStretchCols] : 0.0;
    AddToGradient(by_entry, material.stretch_stride == 0, acts, scratch,
                  gradient + static_cast<std::int64_t>(row) * kStretchEntries * columns + j,
                  columns);
  }
}

template <class Law>
__device__ void ComputeHingeGradient(const ClothView& cloth, const MaterialView& material,
                                     const Law& law, const double* x, const double* w, double h,
                                     const double* lambda, int columns, int chunk,
                                     double* gradient) {
  __shared__ double scratch[kGradientWarps][kBendEntries];
  const int e = chunk * kGradientChunk + threadIdx.x;
  const bool acts = e < cloth.num_hinges;
  const Hinge& hinge = cloth.hinges[acts ? e : 0];
  const HingeSensitivity s =
      EvaluateSensitivity(law, hinge, BendTableAt(material, acts ? e : 0), x, w, h);
  const int row = material.bend_stride != 0 ? e : chunk;
  for (int j = 0; j < columns; ++j) {
    double along = 0.0, by_entry[kBendEntries];
#pragma unroll
    for (int a = 0; a < 4; ++a) {
      const double* at = lambda + 3LL * hinge.vertex[a] * columns + j;
      along += Dot(s.basis.d[a], Vec3<double>{at[0], at[columns], at[2 * columns]});
    }
#pragma unroll
    for (int k = 0; k < kBendEntries; ++k)
      by_entry[k] = acts ? s.by_entry[k / kBendCols][k % kBendCols] * along : 0.0;
    AddToGradient(by_entry, material.bend_stride == 0, acts, scratch,
                  gradient + static_cast<std::int64_t>(row) * kBendEntries * columns + j, columns);
  }
}

// Blocks for the chunks of faces, then for the chunks of hinges.
template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    AdjointMaterial(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                    const double* all_w, double h, const double* all_lambda, GradientView gradient,
                    int columns) {
  const int slot = blockIdx.y, rollout = RolloutAt(batch, slot);
  const MaterialView& material = batch.material[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  const double* lambda = all_lambda + static_cast<std::int64_t>(slot) * cloth.num_dofs() * columns;
  const int face_chunks = (cloth.num_faces + kGradientChunk - 1) / kGradientChunk;
  const int chunk = blockIdx.x;
  if (chunk < face_chunks) {
    FaceGradient(cloth, material, stretch, x, w, h, lambda, columns, chunk,
                 gradient.stretch + gradient.stretch_start[slot]);
  } else {
    ComputeHingeGradient(cloth, material, bend, x, w, h, lambda, columns, chunk - face_chunks,
                         gradient.bend + gradient.bend_start[slot]);
  }
}

}  // namespace

void LaunchAdjointMaterial(const LaunchContext& on, const double* w, double h, const double* lambda,
                           const GradientView& gradient, int columns) {
  const int chunks = BlocksFor(on.cloth.num_faces) + BlocksFor(on.cloth.num_hinges);
  if (chunks == 0) return;
  std::visit(
      [&](const auto& stretch, const auto& bend) {
        AdjointMaterial<<<dim3(chunks, on.batch.slots), kElementThreads, 0, on.stream>>>(
            on.cloth, on.batch, stretch, bend, w, h, lambda, gradient, columns);
      },
      on.law.stretch, on.law.bend);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
