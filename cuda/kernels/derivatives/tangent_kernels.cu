// SPDX-License-Identifier: Apache-2.0
// Products of the step's derivatives with many columns: a thread has the three rows of a vertex and
// one or two neighbouring columns, so that a warp reads whole rows of the columns and the blocks
// are the same for most of it.
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"

namespace drape {
namespace {

// Two neighbouring columns, or one.
template <int Width>
struct Columns {
  double v[Width];
};
template <int Width>
__device__ __forceinline__ Columns<Width> Load(const double* at) {
  if constexpr (Width == 2) {
    const double2 pair = *reinterpret_cast<const double2*>(at);
    return {{pair.x, pair.y}};
  } else {
    return {{at[0]}};
  }
}
template <int Width>
__device__ __forceinline__ void Store(double* at, const Columns<Width>& c) {
  if constexpr (Width == 2) {
    *reinterpret_cast<double2*>(at) = {c.v[0], c.v[1]};
  } else {
    at[0] = c.v[0];
  }
}

// Where a thread works: vertex i, columns from j.
struct Place {
  int i, j;
};
template <int Width>
__device__ __forceinline__ Place FindPlace(int columns) {
  const int groups = columns / Width, index = blockIdx.x * blockDim.x + threadIdx.x;
  return {index / groups, Width * (index % groups)};
}
// sum += row i of A·x, or of Aᵀ·x.
template <int Width, bool kTransposed>
__device__ __forceinline__ void AddRow(const ClothView& cloth, const double* blocks, int i,
                                       const double* x, int columns, Columns<Width> (&sum)[3]) {
  for (int b = cloth.row_start[i]; b < cloth.row_start[i + 1]; ++b) {
    const double* block = blocks + 9LL * (kTransposed ? cloth.mirror[b] : b);
    const double* at = x + 3LL * cloth.column[b] * columns;
#pragma unroll
    for (int k = 0; k < 3; ++k) {
      const Columns<Width> from = Load<Width>(at + k * columns);
#pragma unroll
      for (int r = 0; r < 3; ++r) {
        const double a = block[kTransposed ? 3 * k + r : 3 * r + k];
#pragma unroll
        for (int c = 0; c < Width; ++c) sum[r].v[c] += a * from.v[c];
      }
    }
  }
}

// sum += ∂g/∂p at vertex i for the stretch entries j, j + 1.
__device__ void AddStretchColumns(const ClothView& cloth, const FaceFactors* faces, int i, int j,
                                  Columns<2> (&sum)[3]) {
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution at = Unpack(cloth.to_vertex.item[k]);
    if (at.hinge) return;  // faces come first
    const FaceFactors& face = faces[at.element];
    const CornerGradient shape = GradientOf(cloth.faces[at.element], at.row);
#pragma unroll
    for (int c = 0; c < 2; ++c) {
      const DeformationGradient<double>& basis = face.basis[(j + c) % kStretchCols];
      const Vec3<double> b = face.factor[j + c] * (shape.u * basis.u + shape.v * basis.v);
      sum[0].v[c] += b.x;
      sum[1].v[c] += b.y;
      sum[2].v[c] += b.z;
    }
  }
}
// Adds the columns of the bend entries j, j + 1, of which the last is padding.
__device__ void AddBendColumns(const ClothView& cloth, const HingeFactors* hinges, int i, int j,
                               Columns<2> (&sum)[3]) {
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution at = Unpack(cloth.to_vertex.item[k]);
    if (!at.hinge) continue;
    const HingeFactors& hinge = hinges[at.element];
    const Vec3<double>& d = hinge.basis.d[at.row];
#pragma unroll
    for (int c = 0; c < 2; ++c) {
      const double factor = j + c < kBendEntries ? hinge.factor[j + c] : 0.0;
      sum[0].v[c] += factor * d.x;
      sum[1].v[c] += factor * d.y;
      sum[2].v[c] += factor * d.z;
    }
  }
}

// Threads for the stretch columns of all vertices, then for the bend columns and the further ones:
// the warps are of one kind.
__device__ __forceinline__ Place TangentPlace(int num_vertices, int columns) {
  constexpr int kStretchPairs = kStretchEntries / 2,
                kBendPairs = kPaddedEntries / 2 - kStretchPairs;
  int index = blockIdx.x * blockDim.x + threadIdx.x;
  if (index < num_vertices * kStretchPairs)
    return {index / kStretchPairs, 2 * (index % kStretchPairs)};
  index -= num_vertices * kStretchPairs;
  if (index < num_vertices * kBendPairs)
    return {index / kBendPairs, kStretchEntries + 2 * (index % kBendPairs)};
  index -= num_vertices * kBendPairs;
  const int pairs = (columns - kPaddedEntries) / 2;
  return pairs == 0 ? Place{num_vertices, 0}
                    : Place{index / pairs, kPaddedEntries + 2 * (index % pairs)};
}

__global__ void __launch_bounds__(kElementThreads)
    TangentRhs(ClothView cloth, ShapeBatch batch, FactorRecords all_records,
               const double* all_blocks, const double* dx, double* dv, int columns) {
  const Place at = TangentPlace(cloth.num_vertices, columns);
  if (at.i >= cloth.num_vertices) return;
  const int slot = blockIdx.y;
  const FactorRecords records = all_records.From(cloth, slot);
  const std::int64_t matrix = static_cast<std::int64_t>(slot) * cloth.num_dofs() * columns;
  const std::int64_t rows = matrix + 3LL * at.i * columns + at.j;
  Columns<2> sum[3] = {};
  if (at.j < kStretchEntries) {
    AddStretchColumns(cloth, records.faces, at.i, at.j, sum);
  } else if (at.j < kPaddedEntries) {
    AddBendColumns(cloth, records.hinges, at.i, at.j - kStretchEntries, sum);
  }
  if (dx != nullptr) {
    const double mass = batch.material[RolloutAt(batch, slot)].density * cloth.vertex_area[at.i];
#pragma unroll
    for (int r = 0; r < 3; ++r) {
      const Columns<2> v = Load<2>(dv + rows + r * columns);
      sum[r].v[0] += mass * v.v[0];
      sum[r].v[1] += mass * v.v[1];
    }
    AddRow<2, false>(cloth, all_blocks + 9LL * slot * cloth.num_blocks, at.i, dx + matrix + at.j,
                     columns, sum);
  }
#pragma unroll
  for (int r = 0; r < 3; ++r) Store(dv + rows + r * columns, sum[r]);
}

// rhs = Σ_entries ∂g/∂entry·weight at each vertex.
__global__ void __launch_bounds__(kElementThreads)
    DirectionRhs(ClothView cloth, FactorRecords all_records, double* rhs) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i >= cloth.num_vertices) return;
  const FactorRecords records = all_records.From(cloth, slot);
  Vec3<double> sum{0.0, 0.0, 0.0};
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution at = Unpack(cloth.to_vertex.item[k]);
    if (at.hinge) {
      const HingeFactors& hinge = records.hinges[at.element];
      double factor = 0.0;
#pragma unroll
      for (int n = 0; n < kBendEntries; ++n) factor += hinge.factor[n];
      sum += factor * hinge.basis.d[at.row];
      continue;
    }
    const FaceFactors& face = records.faces[at.element];
    const CornerGradient shape = GradientOf(cloth.faces[at.element], at.row);
#pragma unroll
    for (int m = 0; m < kStretchCols; ++m) {
      double factor = 0.0;
#pragma unroll
      for (int r = 0; r < kStretchRows; ++r) factor += face.factor[kStretchCols * r + m];
      sum += factor * (shape.u * face.basis[m].u + shape.v * face.basis[m].v);
    }
  }
  StoreVec3(RowAt(rhs, slot, cloth.num_dofs()), i, sum);
}

__global__ void LoadHistory(const HistorySlot* history, const int* step, double* x, double* v,
                            int dofs) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= dofs) return;
  const HistorySlot& from = history[blockIdx.y];
  const std::int64_t at = *step * from.stride + i, to = 1LL * blockIdx.y * dofs + i;
  x[to] = from.x[at];
  v[to] = from.v[at];
}

__global__ void AdjointRhs(const double* adj_x, const double* adj_v, double h, double* rhs,
                           int count) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const std::int64_t at = static_cast<std::int64_t>(blockIdx.y) * count + i;
  rhs[at] = adj_v[at] + h * adj_x[at];
}

__global__ void AddSeeds(const double* seeds, double* adj, int count) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= count) return;
  const std::int64_t at = static_cast<std::int64_t>(blockIdx.y) * count + i;
  adj[at] += seeds[at];
}

template <int Width>
__global__ void __launch_bounds__(kElementThreads)
    AdjointPosition(ClothView cloth, ShapeBatch batch, const double* blocks, const double* lambda,
                    double* adj_x, double* adj_v, int columns) {
  const Place at = FindPlace<Width>(columns);
  if (at.i >= cloth.num_vertices) return;
  const int slot = blockIdx.y;
  const std::int64_t matrix = static_cast<std::int64_t>(slot) * cloth.num_dofs() * columns;
  const std::int64_t rows = matrix + 3LL * at.i * columns + at.j;
  const double mass = batch.material[RolloutAt(batch, slot)].density * cloth.vertex_area[at.i];
  Columns<Width> sum[3];
#pragma unroll
  for (int r = 0; r < 3; ++r) sum[r] = Load<Width>(adj_x + rows + r * columns);
  AddRow<Width, true>(cloth, blocks + 9LL * slot * cloth.num_blocks, at.i, lambda + matrix + at.j,
                      columns, sum);
#pragma unroll
  for (int r = 0; r < 3; ++r) {
    Store(adj_x + rows + r * columns, sum[r]);
    Columns<Width> scaled = Load<Width>(lambda + rows + r * columns);
    for (double& v : scaled.v) v *= mass;
    Store(adj_v + rows + r * columns, scaled);
  }
}

template <int Width, bool kTransposed>
__global__ void __launch_bounds__(kElementThreads)
    Multiply(ClothView cloth, const double* blocks, const double* x, double* y, int columns) {
  const Place at = FindPlace<Width>(columns);
  if (at.i >= cloth.num_vertices) return;
  const std::int64_t matrix = static_cast<std::int64_t>(blockIdx.y) * cloth.num_dofs() * columns;
  double* rows = y + matrix + 3LL * at.i * columns + at.j;
  Columns<Width> sum[3];
#pragma unroll
  for (int r = 0; r < 3; ++r) sum[r] = Load<Width>(rows + r * columns);
  AddRow<Width, kTransposed>(cloth, blocks + 9LL * blockIdx.y * cloth.num_blocks, at.i,
                             x + matrix + at.j, columns, sum);
#pragma unroll
  for (int r = 0; r < 3; ++r) Store(rows + r * columns, sum[r]);
}

}  // namespace

void LaunchTangentRhs(const LaunchContext& on, const FactorRecords& records, const double* blocks,
                      const double* dx, double* dv, int columns) {
  LaunchForItems(on, on.cloth.num_vertices * (columns / 2), TangentRhs, on.cloth, on.batch, records,
                 blocks, dx, dv, columns);
}

void LaunchDirectionRhs(const LaunchContext& on, const FactorRecords& records, double* rhs) {
  LaunchForItems(on, on.cloth.num_vertices, DirectionRhs, on.cloth, records, rhs);
}

void LaunchLoadHistory(const LaunchContext& on, const HistorySlot* history, const int* step,
                       double* x, double* v) {
  LaunchForItems(on, on.cloth.num_dofs(), LoadHistory, history, step, x, v, on.cloth.num_dofs());
}

void LaunchAdjointRhs(const LaunchContext& on, const double* adj_x, const double* adj_v, double h,
                      double* rhs, int columns) {
  const int count = on.cloth.num_dofs() * columns;
  LaunchForItems(on, count, AdjointRhs, adj_x, adj_v, h, rhs, count);
}

void LaunchAddSeeds(const LaunchContext& on, const double* seeds, double* adj, int columns) {
  const int count = on.cloth.num_dofs() * columns;
  LaunchForItems(on, count, AddSeeds, seeds, adj, count);
}

void LaunchAdjointPosition(const LaunchContext& on, const double* blocks, const double* lambda,
                           double* adj_x, double* adj_v, int columns) {
  const bool pairs = columns % 2 == 0;
  LaunchForItems(on, on.cloth.num_vertices * (pairs ? columns / 2 : columns),
                 pairs ? AdjointPosition<2> : AdjointPosition<1>, on.cloth, on.batch, blocks,
                 lambda, adj_x, adj_v, columns);
}

void LaunchMultiply(const LaunchContext& on, const double* blocks, bool transposed, const double* x,
                    double* y, int columns) {
  const bool pairs = columns % 2 == 0;
  const auto kernel = pairs ? (transposed ? Multiply<2, true> : Multiply<2, false>)
                            : (transposed ? Multiply<1, true> : Multiply<1, false>);
  LaunchForItems(on, on.cloth.num_vertices * (pairs ? columns / 2 : columns), kernel, on.cloth,
                 blocks, x, y, columns);
}

}  // namespace drape
