// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/element_kernels.h"
#include "physics/cloth/assembly/air_element.h"

namespace drape {
namespace {

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    ElementRecords(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                   StepRecords all_records) {
  __shared__ Stage stage;
  const ElementThread at = FindElement(cloth, batch);
  const StepRecords records = all_records.From(cloth, at.slot);
  if (!at.is_hinge) {
    const int f = min(at.i, cloth.num_faces - 1);
    const DeformationGradient<double> F = GatherColumns(cloth.faces[f], at.x);
    const FaceRecord record{F, EvaluateStretch(stretch, Green(F), StretchTableAt(at.material, f))};
    StoreRecord(record, records.faces, at.i, cloth.num_faces, stage);
  } else {
    const int e = min(at.i, cloth.num_hinges - 1);
    const HingeCorners corners = GatherCorners(cloth.hinges[e], at.x);
    const double theta = DihedralAngle(corners);
    const double kappa = HingeStiffness(bend, cloth.hinges[e], BendTableAt(at.material, e), theta);
    const HingeMeasure mu = bend.Measure(theta);
    const HingeRecord record{AngleGradient(EvaluateWings(corners)), kappa * mu.value,
                             kappa * mu.slope};
    StoreRecord(record, records.hinges, at.i, cloth.num_hinges, stage);
  }
}

__device__ double& Component(Vec3<double>& a, int i) { return i == 0 ? a.x : i == 1 ? a.y : a.z; }

// block += area·(∂/∂x_b of H·w at corner a), column by column.
__device__ void AddFaceBlock(const Face& face, const FaceRecord& record, int a, int b, double scale,
                             double (&block)[9]) {
  const CornerGradient row = GradientOf(face, a), at_b = GradientOf(face, b);
  const double ua = face.area * scale * row.u, va = face.area * scale * row.v;
#pragma unroll
  for (int j = 0; j < 3; ++j) {
    DeformationGradient<double> w{{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    Component(w.u, j) = at_b.u;
    Component(w.v, j) = at_b.v;
    const DeformationGradient<double> column = StretchStiffnessTimes(record.k, record.F, w);
    const Vec3<double> at_a = ua * column.u + va * column.v;
    block[j] += at_a.x;
    block[3 + j] += at_a.y;
    block[6 + j] += at_a.z;
  }
}

__device__ void AddHingeBlock(const HingeRecord& record, int a, int b, double scale,
                              double (&block)[9]) {
  const Vec3<double> row = (scale * record.stiffness) * record.gradient.d[a];
  const Vec3<double>& column = record.gradient.d[b];
  const double rows[3] = {row.x, row.y, row.z}, columns[3] = {column.x, column.y, column.z};
#pragma unroll
  for (int k = 0; k < 9; ++k) block[k] += rows[k / 3] * columns[k % 3];
}

// The air at one corner of a face, with the velocity v before the step [MODEL, M65].
struct AirAtCorner {
  Vec3<double> normal;     // its side does not matter
  double drag, with_wind;  // of the step matrix d·n·nᵀ [kg], and n·wind [m/s]
};
__device__ AirAtCorner FindAir(const MaterialView& material, const Face& face,
                               const DeformationGradient<double>& F, const Vec3<double>& v,
                               double h) {
  using std::sqrt;
  const Vec3<double> N = Cross(F.u, F.v),
                     wind{material.wind[0], material.wind[1], material.wind[2]};
  const Vec3<double> n = (1.0 / sqrt(Dot(N, N))) * N;
  return {n, AirCoefficient(h * material.air_drag * face.area / 3.0, n, v, wind), Dot(n, wind)};
}

// v: velocities before the step where air acts.
__device__ void GatherStepBlock(const ClothView& cloth, const MaterialView& material,
                                const StepRecords& records, const double* v, double h, int entry,
                                double (&block)[9]) {
  const FrontEntry& place = cloth.entries[entry];
  if (place.row == place.column) {
    const int i = place.row;
    double diagonal = material.density * cloth.vertex_area[i] + h * h * cloth.handle[i];
    if (material.mass_damping != 0.0)
      diagonal += h * material.mass_damping * material.density * cloth.vertex_area[i];
    block[0] = block[4] = block[8] = diagonal;
  }
  const double h2 = h * (h + material.stiffness_damping);
  const int end = cloth.to_entry.start[entry + 1];
  int k = cloth.to_entry.start[entry], item = k < end ? cloth.to_entry.item[k] : 0;
  while (k < end) {
    const Contribution c = Unpack(item);
    if (++k < end) item = cloth.to_entry.item[k];  // before the record is waited for
    if (c.hinge) {
      AddHingeBlock(records.hinges[c.element], c.row, c.column, h2, block);
    } else {
      const Face& face = cloth.faces[c.element];
      AddFaceBlock(face, records.faces[c.element], c.row, c.column, h2, block);
      if (v == nullptr || place.row != place.column) continue;
      const AirAtCorner air =
          FindAir(material, face, records.faces[c.element].F, LoadVec3(v, place.row), h);
      const double n[3] = {air.normal.x, air.normal.y, air.normal.z};
#pragma unroll
      for (int j = 0; j < 9; ++j) block[j] += air.drag * n[j / 3] * n[j % 3];
    }
  }
}

__device__ Vec3<double> ForceOnVertex(const ClothView& cloth, const MaterialView& material,
                                      const StepRecords& records, const double* x, int i) {
  const double mass = material.density * cloth.vertex_area[i];
  Vec3<double> force =
      LoadVec3(cloth.load, i) - cloth.handle[i] * (LoadVec3(x, i) - LoadVec3(cloth.rest_x, i));
  force += mass * Vec3<double>{cloth.gravity[0], cloth.gravity[1], cloth.gravity[2]};
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_vertex.item[k]);
    if (c.hinge) {
      const HingeRecord& hinge = records.hinges[c.element];
      force += -hinge.moment * hinge.gradient.d[c.row];
    } else {
      const Face& face = cloth.faces[c.element];
      const CornerGradient shape = GradientOf(face, c.row);
      const FaceRecord& record = records.faces[c.element];
      const DeformationGradient<double> by_area = StretchForce(record.k, record.F);
      force += (face.area * shape.u) * by_area.u + (face.area * shape.v) * by_area.v;
    }
  }
  return force;
}

// The impulse of the wind on a vertex that does not move [N·s].
__device__ Vec3<double> WindOnVertex(const ClothView& cloth, const MaterialView& material,
                                     const StepRecords& records, const Vec3<double>& v, double h,
                                     int i) {
  Vec3<double> impulse{0.0, 0.0, 0.0};
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_vertex.item[k]);
    if (c.hinge) continue;
    const AirAtCorner air =
        FindAir(material, cloth.faces[c.element], records.faces[c.element].F, v, h);
    impulse += (air.drag * air.with_wind) * air.normal;
  }
  return impulse;
}

// Warps for the matrix blocks, then threads for the vertices.
__global__ void __launch_bounds__(kElementThreads)
    GatherStep(ClothView cloth, ShapeBatch batch, StepRecords all_records, const double* v,
               double h, double* matrix, double* rhs) {
  __shared__ Stage stage;
  const int item = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  const int rollout = RolloutAt(batch, slot);
  const MaterialView& material = batch.material[rollout];
  const StepRecords records = all_records.From(cloth, slot);
  const int padded_entries = (cloth.num_entries + 31) / 32 * 32;
  const double* own_v = v == nullptr ? nullptr : RowAt(v, slot, cloth.num_dofs());
  const double* in_air = material.air_drag == 0.0 ? nullptr : own_v;
  if (item < padded_entries) {
    const int entry = item < cloth.num_entries ? cloth.entry_order[item] : -1;
    double block[9] = {};
    if (entry >= 0) GatherStepBlock(cloth, material, records, in_air, h, entry, block);
    StoreBlock(block, matrix + 9LL * slot * cloth.num_entries, entry, stage);
  }
  if (const int i = item - padded_entries; rhs != nullptr && i >= 0 && i < cloth.num_vertices) {
    const double* x = RowAt(batch.x, rollout, cloth.num_dofs());
    const double mass = material.density * cloth.vertex_area[i];
    const Vec3<double> force = ForceOnVertex(cloth, material, records, x, i);
    Vec3<double> sum = mass * LoadVec3(own_v, i) + h * force;
    if (in_air != nullptr) sum += WindOnVertex(cloth, material, records, LoadVec3(own_v, i), h, i);
    StoreVec3(RowAt(rhs, slot, cloth.num_dofs()), i, sum);
  }
}

__global__ void __launch_bounds__(kElementThreads)
    GatherForce(ClothView cloth, ShapeBatch batch, StepRecords records, double* force) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i >= cloth.num_vertices) return;
  const int rollout = RolloutAt(batch, slot);
  const Vec3<double> sum = ForceOnVertex(cloth, batch.material[rollout], records.From(cloth, slot),
                                         RowAt(batch.x, rollout, cloth.num_dofs()), i);
  StoreVec3(RowAt(force, rollout, cloth.num_dofs()), i, sum);
}

__global__ void Advance(int num_dofs, StepState state, const double* solution, double h,
                        HistoryView history) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i >= num_dofs) return;
  const std::int64_t at = static_cast<std::int64_t>(slot) * num_dofs + i;
  const double v = solution[at], x = state.x[at];
  if (!isfinite(v)) state.failed[slot] = 1;
  if (history.x != nullptr) {
    const std::int64_t kept = *history.step * history.stride + at;
    history.x[kept] = x;
    history.v[kept] = v;
  }
  state.v[at] = v;
  state.x[at] = x + h * v;
}

__global__ void CountStep(int* step, int by) { *step += by; }

}  // namespace

void LaunchElementRecords(const LaunchContext& on, const StepRecords& records) {
  LaunchForChunks(on, [&](dim3 grid, const auto& stretch, const auto& bend) {
    ElementRecords<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch, bend,
                                                            records);
  });
}

void LaunchGatherStep(const LaunchContext& on, const StepRecords& records, const double* v,
                      double h, double* matrix, double* rhs) {
  const int vertices = rhs == nullptr ? 0 : on.cloth.num_vertices;
  LaunchForItems(on, (on.cloth.num_entries + 31) / 32 * 32 + vertices, GatherStep, on.cloth,
                 on.batch, records, v, h, matrix, rhs);
  LaunchAddContactStep(on, h, matrix, rhs);
}

void LaunchGatherForce(const LaunchContext& on, const StepRecords& records, double* force) {
  LaunchForItems(on, on.cloth.num_vertices, GatherForce, on.cloth, on.batch, records, force);
  LaunchAddContactForce(on, force);
}

void LaunchAdvance(const LaunchContext& on, const StepState& state, const double* solution,
                   double h, const HistoryView& history) {
  const int dofs = on.cloth.num_dofs();
  LaunchForItems(on, dofs, Advance, dofs, state, solution, h, history);
}

void LaunchCountStep(int* step, int by, cudaStream_t stream) {
  CountStep<<<1, 1, 0, stream>>>(step, by);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
