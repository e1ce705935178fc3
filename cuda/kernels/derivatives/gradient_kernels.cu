// SPDX-License-Identifier: Apache-2.0
#include "cuda/device/cuda_error.h"
#include "cuda/kernels/contact_kernels.h"
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"
#include "physics/material/laws/element_sensitivity.h"

// Gradients of m scalars by the material tables: a thread has one element, a block a chunk of them.
// The adjoint of a step for one right-hand side: adjoints of the element functions, then sums
// by gather.

namespace drape {
namespace {

// Sums of gradients over the elements of a block of threads, one thread per element.

static_assert(kGradientChunk == kElementThreads);
constexpr int kGradientWarps = kGradientChunk / 32;

// Adds the sums over the block to `to`, rows `columns` apart: a fixed tree in each warp, then the
// warps in order.
template <int N>
__device__ void ReduceToRow(const double (&value)[N], double (&scratch)[kGradientWarps][N],
                            double* to, int columns) {
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

// The numbers of one element to the row of the block where one table serves all, or to its own.
template <int N>
__device__ void AddToGradient(const double (&value)[N], bool shared_table, bool acts,
                              double (&scratch)[kGradientWarps][N], double* to, int columns) {
  if (shared_table) {
    ReduceToRow(value, scratch, to, columns);
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

template <class Law>
__device__ void AdjointOfFace(const ClothView& cloth, const MaterialView& material, const Law& law,
                              const double* x, const double* w, double h, const double* lambda,
                              int chunk, DeformationGradient<double>* records, double* gradient) {
  __shared__ double scratch[kGradientWarps][kStretchEntries];
  const int f = chunk * kGradientChunk + threadIdx.x;
  const bool acts = f < cloth.num_faces;
  const Face& face = cloth.faces[acts ? f : 0];
  const StretchTable& table = StretchTableAt(material, acts ? f : 0);
  const StretchAdjoint adjoint = AdjStretchStep(
      law, GatherColumns(face, x), table, GatherColumns(face, w), h, GatherColumns(face, lambda));
  if (acts) records[f] = adjoint.adj_F;
  double by_entry[kStretchRows][kStretchCols], sum[kStretchEntries];
  law.StiffnessByTable(adjoint.G, table, by_entry);
#pragma unroll
  for (int k = 0; k < kStretchEntries; ++k)
    sum[k] = acts ? face.area * adjoint.adj_stiffness[k % kStretchCols] *
                        by_entry[k / kStretchCols][k % kStretchCols]
                  : 0.0;
  const std::int64_t row = material.stretch_stride != 0 ? f : chunk;
  AddToGradient(sum, material.stretch_stride == 0, acts, scratch, gradient + row * kStretchEntries,
                1);
}

template <class Law>
__device__ void AdjointOfHinge(const ClothView& cloth, const MaterialView& material, const Law& law,
                               const double* x, const double* w, double h, const double* lambda,
                               int chunk, BendAdjoint* records, double* gradient) {
  __shared__ double scratch[kGradientWarps][kBendEntries];
  const int e = chunk * kGradientChunk + threadIdx.x;
  const bool acts = e < cloth.num_hinges;
  const Hinge& hinge = cloth.hinges[acts ? e : 0];
  const BendTable& table = BendTableAt(material, acts ? e : 0);
  const HingeCorners corners = GatherCorners(hinge, x);
  const double theta = DihedralAngle(corners);
  const BendAdjoint adjoint = AdjBendStep(law, hinge, table, corners, GatherCorners(hinge, w), h,
                                          GatherCorners(hinge, lambda), theta);
  if (acts) records[e] = adjoint;
  double by_entry[kBendRows][kBendCols], sum[kBendEntries];
  HingeStiffnessByTable(law, hinge, table, theta, by_entry);
#pragma unroll
  for (int k = 0; k < kBendEntries; ++k)
    sum[k] = acts ? adjoint.adj_kappa * by_entry[k / kBendCols][k % kBendCols] : 0.0;
  const std::int64_t row = material.bend_stride != 0 ? e : chunk;
  AddToGradient(sum, material.bend_stride == 0, acts, scratch, gradient + row * kBendEntries, 1);
}

// Blocks for the chunks of faces, then for the chunks of hinges.
template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    AdjointOfElements(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                      const double* all_w, double h, const double* all_lambda,
                      AdjointRecords records, GradientView gradient) {
  const int slot = blockIdx.y, rollout = RolloutAt(batch, slot);
  const MaterialView& material = batch.material[rollout];
  const double* x = NodesOf(batch.x, rollout, cloth.num_dofs());
  const double* w = NodesOf(all_w, slot, cloth.num_dofs());
  const double* lambda = NodesOf(all_lambda, slot, cloth.num_dofs());
  const int face_chunks = (cloth.num_faces + kGradientChunk - 1) / kGradientChunk;
  const int chunk = blockIdx.x;
  if (chunk < face_chunks) {
    AdjointOfFace(cloth, material, stretch, x, w, h, lambda, chunk,
                  records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces,
                  gradient.stretch + gradient.stretch_start[slot]);
  } else {
    AdjointOfHinge(cloth, material, bend, x, w, h, lambda, chunk - face_chunks,
                   records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges,
                   gradient.bend + gradient.bend_start[slot]);
  }
}

__global__ void __launch_bounds__(kElementThreads)
    GatherAdjoint(ClothView cloth, ShapeBatch batch, AdjointRecords records, double h,
                  const double* all_lambda, double* all_x, double* all_v) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i >= cloth.num_vertices) return;
  const DeformationGradient<double>* faces =
      records.faces + static_cast<std::int64_t>(slot) * cloth.num_faces;
  const BendAdjoint* hinges = records.hinges + static_cast<std::int64_t>(slot) * cloth.num_hinges;
  const Vec3<double> lambda = LoadVec3(NodesOf(all_lambda, slot, cloth.num_dofs()), i);
  Vec3<double> sum = (-h * cloth.handle[i]) * lambda;
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_vertex.item[k]);
    if (c.hinge) {
      sum += LoadVec3(hinges[c.element].adj_x, c.row);
    } else {
      const Face& face = cloth.faces[c.element];
      const CornerGradient shape = GradientOf(face, c.row);
      const DeformationGradient<double>& by_area = faces[c.element];
      sum += (face.area * shape.u) * by_area.u + (face.area * shape.v) * by_area.v;
    }
  }
  AddTo(NodesOf(all_x, slot, cloth.num_dofs()), i, sum);
  const double mass = batch.material[RolloutAt(batch, slot)].density * cloth.vertex_area[i];
  double* v = NodesOf(all_v, slot, cloth.num_dofs()) + 3 * i;
  v[0] = mass * lambda.x;
  v[1] = mass * lambda.y;
  v[2] = mass * lambda.z;
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

void LaunchAdjointRecords(const LaunchContext& on, const double* w, double h, const double* lambda,
                          const AdjointRecords& records, const GradientView& gradient) {
  const int chunks = BlocksFor(on.cloth.num_faces) + BlocksFor(on.cloth.num_hinges);
  if (chunks == 0) return;
  std::visit(
      [&](const auto& stretch, const auto& bend) {
        AdjointOfElements<<<dim3(chunks, on.batch.slots), kElementThreads, 0, on.stream>>>(
            on.cloth, on.batch, stretch, bend, w, h, lambda, records, gradient);
      },
      on.law.stretch, on.law.bend);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchGatherAdjoint(const LaunchContext& on, const AdjointRecords& records, const double* w,
                         double h, const double* lambda, double* adj_x, double* adj_v) {
  GatherAdjoint<<<dim3(BlocksFor(on.cloth.num_vertices), on.batch.slots), kElementThreads, 0,
                  on.stream>>>(on.cloth, on.batch, records, h, lambda, adj_x, adj_v);
  CUDA_CHECK(cudaGetLastError());
  LaunchAddContactAdjoint(on, w, h, lambda, adj_x);
}

}  // namespace drape
