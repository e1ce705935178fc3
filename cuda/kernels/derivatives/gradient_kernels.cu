// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/element_kernels.h"
#include "physics/material/laws/element_sensitivity.h"

// Gradients of m scalars by the material tables: a thread has one element, a block a chunk of them.
// The adjoint of a step for one right-hand side: adjoints of the element functions, then sums
// by gather.

namespace drape {
namespace {

// Sums of gradients over the elements of a block of threads, one thread per element.

constexpr int kGradientWarps = kGradientChunk / 32;

// Adds the sums over the block to `to`, rows `columns` apart: a fixed tree in each warp, then the
// warps in order.
template <int N>
__device__ void ReduceToRow(const double (&value)[N], double* to, int columns) {
  __shared__ double scratch[kGradientWarps][N];
#pragma unroll
  for (int k = 0; k < N; ++k) {
    double sum = value[k];
    for (int offset = 16; offset > 0; offset >>= 1)
      sum += __shfl_down_sync(0xffffffffu, sum, offset);
    if ((threadIdx.x & 31) == 0) scratch[threadIdx.x >> 5][k] = sum;
  }
  __syncthreads();
  if (threadIdx.x < N) {
    double sum = 0.0;
    for (int warp = 0; warp < kGradientWarps; ++warp) sum += scratch[warp][threadIdx.x];
    to[threadIdx.x * static_cast<std::int64_t>(columns)] += sum;
  }
  __syncthreads();
}

// Adds the numbers of element i, if it acts, to column `column` of its rows of the gradient, or of
// the rows of its chunk where one table serves all.
template <int N>
__device__ void AddToGradient(const double (&value)[N], bool shared_table, int i, bool acts,
                              double* gradient, int column, int columns) {
  const std::int64_t row = shared_table ? i / kGradientChunk : i;
  double* to = gradient + row * N * columns + column;
  if (shared_table) {
    ReduceToRow(value, to, columns);
  } else if (acts) {
#pragma unroll
    for (int k = 0; k < N; ++k) to[k * static_cast<std::int64_t>(columns)] += value[k];
  }
}

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
__device__ void FaceGradient(const ClothView& cloth, const ElementThread& at, const Law& law,
                             const double* w, double h, const double* lambda, int columns,
                             double* gradient) {
  const bool acts = at.i < cloth.num_faces, shared_table = at.material.stretch_stride == 0;
  const int f = acts ? at.i : 0;
  const Face& face = cloth.faces[f];
  const FaceSensitivity s =
      EvaluateSensitivity(law, face, StretchTableAt(at.material, f), at.x, w, h);
  for (int j = 0; j < columns; ++j) {
    double along[kStretchCols], by_entry[kStretchEntries];
    AlongBasis(face, s, lambda + j, columns, along);
#pragma unroll
    for (int k = 0; k < kStretchEntries; ++k)
      by_entry[k] =
          acts ? s.by_entry[k / kStretchCols][k % kStretchCols] * along[k % kStretchCols] : 0.0;
    AddToGradient(by_entry, shared_table, at.i, acts, gradient, j, columns);
  }
}

template <class Law>
__device__ void ComputeHingeGradient(const ClothView& cloth, const ElementThread& at,
                                     const Law& law, const double* w, double h,
                                     const double* lambda, int columns, double* gradient) {
  const bool acts = at.i < cloth.num_hinges, shared_table = at.material.bend_stride == 0;
  const int e = acts ? at.i : 0;
  const Hinge& hinge = cloth.hinges[e];
  const HingeSensitivity s =
      EvaluateSensitivity(law, hinge, BendTableAt(at.material, e), at.x, w, h);
  for (int j = 0; j < columns; ++j) {
    double along = 0.0, by_entry[kBendEntries];
#pragma unroll
    for (int a = 0; a < 4; ++a) {
      const double* l = lambda + 3LL * hinge.vertex[a] * columns + j;
      along += Dot(s.basis.d[a], Vec3<double>{l[0], l[columns], l[2 * columns]});
    }
#pragma unroll
    for (int k = 0; k < kBendEntries; ++k)
      by_entry[k] = acts ? s.by_entry[k / kBendCols][k % kBendCols] * along : 0.0;
    AddToGradient(by_entry, shared_table, at.i, acts, gradient, j, columns);
  }
}

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    AdjointMaterial(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                    const double* all_w, double h, const double* all_lambda, GradientView gradient,
                    int columns) {
  const ElementThread at = FindElement(cloth, batch);
  const double* w = RowAt(all_w, at.slot, cloth.num_dofs());
  const double* lambda = RowAt(all_lambda, at.slot, cloth.num_dofs() * columns);
  if (!at.is_hinge) {
    FaceGradient(cloth, at, stretch, w, h, lambda, columns,
                 gradient.stretch + gradient.stretch_start[at.slot]);
  } else {
    ComputeHingeGradient(cloth, at, bend, w, h, lambda, columns,
                         gradient.bend + gradient.bend_start[at.slot]);
  }
}

template <class Law>
__device__ void AdjointOfFace(const ClothView& cloth, const ElementThread& at, const Law& law,
                              const double* w, double h, const double* lambda,
                              DeformationGradient<double>* records, double* gradient) {
  const bool acts = at.i < cloth.num_faces;
  const int f = acts ? at.i : 0;
  const Face& face = cloth.faces[f];
  const StretchTable& table = StretchTableAt(at.material, f);
  const StretchAdjoint adjoint =
      AdjStretchStep(law, GatherColumns(face, at.x), table, GatherColumns(face, w), h,
                     GatherColumns(face, lambda));
  if (acts) records[f] = adjoint.adj_F;
  double sum[kStretchEntries];
#pragma unroll
  for (int k = 0; k < kStretchEntries; ++k)
    sum[k] = acts ? face.area * adjoint.adj_stiffness[k % kStretchCols] *
                        adjoint.by_entry[k / kStretchCols][k % kStretchCols]
                  : 0.0;
  AddToGradient(sum, at.material.stretch_stride == 0, at.i, acts, gradient, 0, 1);
}

template <class Law>
__device__ void AdjointOfHinge(const ClothView& cloth, const ElementThread& at, const Law& law,
                               const double* w, double h, const double* lambda,
                               BendAdjoint* records, double* gradient) {
  const bool acts = at.i < cloth.num_hinges;
  const int e = acts ? at.i : 0;
  const Hinge& hinge = cloth.hinges[e];
  const BendTable& table = BendTableAt(at.material, e);
  const HingeCorners corners = GatherCorners(hinge, at.x);
  const double theta = DihedralAngle(corners);
  const auto columns = law.Columns(hinge, Dual<1>(theta, 0));
  const BendAdjoint adjoint =
      AdjBendStep(law, hinge, table, columns, corners, GatherCorners(hinge, w), h,
                  GatherCorners(hinge, lambda), theta);
  if (acts) records[e] = adjoint;
  double by_entry[kBendRows][kBendCols], sum[kBendEntries];
  HingeStiffnessByTable(law, hinge, table, columns, by_entry);
#pragma unroll
  for (int k = 0; k < kBendEntries; ++k)
    sum[k] = acts ? adjoint.adj_kappa * by_entry[k / kBendCols][k % kBendCols] : 0.0;
  AddToGradient(sum, at.material.bend_stride == 0, at.i, acts, gradient, 0, 1);
}

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    AdjointOfElements(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                      const double* all_w, double h, const double* all_lambda,
                      AdjointRecords all_records, GradientView gradient) {
  const ElementThread at = FindElement(cloth, batch);
  const AdjointRecords records = all_records.From(cloth, at.slot);
  const double* w = RowAt(all_w, at.slot, cloth.num_dofs());
  const double* lambda = RowAt(all_lambda, at.slot, cloth.num_dofs());
  if (!at.is_hinge) {
    AdjointOfFace(cloth, at, stretch, w, h, lambda, records.faces,
                  gradient.stretch + gradient.stretch_start[at.slot]);
  } else {
    AdjointOfHinge(cloth, at, bend, w, h, lambda, records.hinges,
                   gradient.bend + gradient.bend_start[at.slot]);
  }
}

__global__ void __launch_bounds__(kElementThreads)
    GatherAdjoint(ClothView cloth, ShapeBatch batch, AdjointRecords all_records, double h,
                  const double* all_lambda, double* all_x, double* all_v) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i >= cloth.num_vertices) return;
  const AdjointRecords records = all_records.From(cloth, slot);
  const Vec3<double> lambda = LoadVec3(RowAt(all_lambda, slot, cloth.num_dofs()), i);
  Vec3<double> sum = (-h * cloth.handle[i]) * lambda;
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_vertex.item[k]);
    if (c.hinge) {
      sum += records.hinges[c.element].adj_x.d[c.row];
    } else {
      const Face& face = cloth.faces[c.element];
      const CornerGradient shape = GradientOf(face, c.row);
      const DeformationGradient<double>& by_area = records.faces[c.element];
      sum += (face.area * shape.u) * by_area.u + (face.area * shape.v) * by_area.v;
    }
  }
  AddTo(RowAt(all_x, slot, cloth.num_dofs()), i, sum);
  const double mass = batch.material[RolloutAt(batch, slot)].density * cloth.vertex_area[i];
  StoreVec3(RowAt(all_v, slot, cloth.num_dofs()), i, mass * lambda);
}

}  // namespace

void LaunchAdjointMaterial(const LaunchContext& on, const double* w, double h, const double* lambda,
                           const GradientView& gradient, int columns) {
  LaunchForChunks(on, [&](dim3 grid, const auto& stretch, const auto& bend) {
    AdjointMaterial<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch, bend, w,
                                                             h, lambda, gradient, columns);
  });
}

void LaunchAdjointRecords(const LaunchContext& on, const double* w, double h, const double* lambda,
                          const AdjointRecords& records, const GradientView& gradient) {
  LaunchForChunks(on, [&](dim3 grid, const auto& stretch, const auto& bend) {
    AdjointOfElements<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch, bend, w,
                                                               h, lambda, records, gradient);
  });
}

void LaunchGatherAdjoint(const LaunchContext& on, const AdjointRecords& records, const double* w,
                         double h, const double* lambda, double* adj_x, double* adj_v) {
  LaunchForItems(on, on.cloth.num_vertices, GatherAdjoint, on.cloth, on.batch, records, h, lambda,
                 adj_x, adj_v);
  LaunchAddContactAdjoint(on, w, h, lambda, adj_x);
}

}  // namespace drape
