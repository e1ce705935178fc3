// SPDX-License-Identifier: Apache-2.0
// Derivatives of a step by density, damping, drag and wind, and of its air by position and
// velocity.
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/reduce.cuh"
#include "physics/cloth/assembly/air_element.h"

namespace drape {
namespace {

// A slot's step: the shape, and the velocities before and after it, [3V].
struct MovingSlot {
  const MaterialView& material;
  const double *x, *v, *w;
  double h;

  __device__ double FaceDrag(const Face& face) const {
    return h * material.air_drag * face.area / 3.0;
  }
};
__device__ MovingSlot FindMovingSlot(const ClothView& cloth, const ShapeBatch& batch,
                                     const MovingStepView& step) {
  const int slot = blockIdx.y, rollout = RolloutAt(batch, slot), dofs = cloth.num_dofs();
  return {batch.material[rollout], RowAt(batch.x, rollout, dofs), RowAt(step.v, slot, dofs),
          RowAt(step.w, slot, dofs), step.h};
}

template <class T>
__device__ Vec3<T> LoadWind(const MaterialView& material) {
  return {material.wind[0], material.wind[1], material.wind[2]};
}
template <class T>
__device__ Vec3<T> Load(const double* nodes, int i) {
  return {nodes[3 * i], nodes[3 * i + 1], nodes[3 * i + 2]};
}
template <int N>
__device__ Vec3<Dual<N>> Seeded(const Vec3<double>& a, int first) {
  return {{a.x, first}, {a.y, first + 1}, {a.z, first + 2}};
}
// Vertex i of a matrix of `columns` columns, of which `at` is the first row's of one.
__device__ Vec3<double> LoadColumn(const double* at, int i, int columns) {
  at += 3LL * i * columns;
  return {at[0], at[columns], at[2 * columns]};
}
__device__ void AddToColumn(double* at, int i, int columns, const Vec3<double>& a) {
  at += 3LL * i * columns;
  at[0] += a.x;
  at[columns] += a.y;
  at[2 * columns] += a.z;
}

// A vertex's rows of the columns.
using VertexColumns = double[3][kDynamicsNumbers];

__device__ void AddInertia(const ClothView& cloth, const MovingSlot& at, int i,
                           VertexColumns& sum) {
  const double area = cloth.vertex_area[i], damping = at.h * at.material.mass_damping;
#pragma unroll
  for (int r = 0; r < 3; ++r) {
    const double w = at.w[3 * i + r];
    sum[r][0] += area * (at.v[3 * i + r] - (1.0 + damping) * w + at.h * cloth.gravity[r]);
    sum[r][1] -= at.h * at.material.density * area * w;
  }
}

template <class Law>
__device__ void AddFaceColumns(const ClothView& cloth, const Law& law, const MovingSlot& at, int f,
                               int corner, VertexColumns& sum) {
  const Face& face = cloth.faces[f];
  const DeformationGradient<double> F = GatherColumns(face, at.x);
  const auto k = EvaluateStretch(law, Green(F), StretchTableAt(at.material, f));
  const auto Hw = StretchStiffnessTimes(k, F, GatherColumns(face, at.w));
  const CornerGradient shape = GradientOf(face, corner);
  const double scale = -at.h * face.area;
  const Vec3<double> stiff = (scale * shape.u) * Hw.u + (scale * shape.v) * Hw.v;
  const int i = face.vertex[corner];
  const Vec3<double> corners[3] = {LoadVec3(at.x, face.vertex[0]), LoadVec3(at.x, face.vertex[1]),
                                   LoadVec3(at.x, face.vertex[2])};
  const Vec3<double> normal = UnitNormal(corners);
  Dual<4> drag = at.FaceDrag(face);
  drag.v[0] = at.h * face.area / 3.0;
  const Vec3<Dual<4>> n{normal.x, normal.y, normal.z};
  const auto impulse = AirImpulse(drag, n, Load<Dual<4>>(at.v, i), Load<Dual<4>>(at.w, i),
                                  Seeded<4>(LoadWind<double>(at.material), 1));
  const double stiffs[3] = {stiff.x, stiff.y, stiff.z};
  const Dual<4> impulses[3] = {impulse.x, impulse.y, impulse.z};
#pragma unroll
  for (int r = 0; r < 3; ++r) {
    sum[r][2] += stiffs[r];
#pragma unroll
    for (int j = 0; j < 4; ++j) sum[r][3 + j] += impulses[r].v[j];
  }
}

template <class Law>
__device__ void AddHingeColumns(const ClothView& cloth, const Law& law, const MovingSlot& at, int e,
                                int corner, VertexColumns& sum) {
  const Hinge& hinge = cloth.hinges[e];
  const HingeCorners corners = GatherCorners(hinge, at.x);
  const double theta = DihedralAngle(corners);
  const HingeGradient d = AngleGradient(EvaluateWings(corners));
  const double moment = -at.h * HingeStiffness(law, hinge, BendTableAt(at.material, e), theta) *
                        law.Measure(theta).slope * Dot(d, GatherCorners(hinge, at.w));
  const Vec3<double> stiff = moment * d.d[corner];
  sum[0][2] += stiff.x;
  sum[1][2] += stiff.y;
  sum[2][2] += stiff.z;
}

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kElementThreads)
    DynamicsColumns(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                    MovingStepView step, DynamicsPlace place) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= cloth.num_vertices) return;
  const MovingSlot at = FindMovingSlot(cloth, batch, step);
  VertexColumns sum = {};
  AddInertia(cloth, at, i, sum);
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_vertex.item[k]);
    if (c.hinge)
      AddHingeColumns(cloth, bend, at, c.element, c.row, sum);
    else
      AddFaceColumns(cloth, stretch, at, c.element, c.row, sum);
  }
  double* to = RowAt(place.matrix, blockIdx.y, cloth.num_dofs() * place.columns) +
               3LL * i * place.columns + place.first;
  for (int r = 0; r < 3; ++r)
#pragma unroll
    for (int k = 0; k < kDynamicsNumbers; ++k)
      if (k < place.count)
        to[r * place.columns + k] = sum[r][k] + (place.adds ? to[r * place.columns + k] : 0.0);
}

// A block of threads has one slot and one right-hand side, and adds the rows in a fixed order.
__global__ void __launch_bounds__(kReduceThreads)
    DynamicsGradient(const double* numbers, const double* lambda, int dofs, int columns,
                     double* gradient) {
  const int slot = blockIdx.x, j = blockIdx.y;
  const double* of_slot = RowAt(numbers, slot, dofs * kDynamicsNumbers);
  const double* along = RowAt(lambda, slot, dofs * columns) + j;
  double sum[kDynamicsNumbers] = {};
  for (int row = threadIdx.x; row < dofs; row += kReduceThreads) {
    const double l = along[1LL * row * columns];
#pragma unroll
    for (int k = 0; k < kDynamicsNumbers; ++k) sum[k] += of_slot[row * kDynamicsNumbers + k] * l;
  }
  double* to = RowAt(gradient, slot, kDynamicsNumbers * columns) + j;
#pragma unroll
  for (int k = 0; k < kDynamicsNumbers; ++k) {
    const double all = SumOfBlock(sum[k]);
    if (threadIdx.x == 0) to[k * columns] += all;
  }
}

// Vertex and column of a thread; neighbouring threads have neighbouring columns.
struct Item {
  int i, column;
};
__device__ Item FindItem(int columns) {
  const int index = blockIdx.x * blockDim.x + threadIdx.x;
  return {index / columns, index % columns};
}

__global__ void __launch_bounds__(kElementThreads)
    AirTangent(ClothView cloth, ShapeBatch batch, MovingStepView step, const double* all_dx,
               double* all_dv, int columns) {
  const auto [i, column] = FindItem(columns);
  if (i >= cloth.num_vertices) return;
  const MovingSlot at = FindMovingSlot(cloth, batch, step);
  if (at.material.air_drag == 0.0) return;
  const int size = cloth.num_dofs() * columns;
  const double* dx = RowAt(all_dx, blockIdx.y, size) + column;
  double* dv = RowAt(all_dv, blockIdx.y, size) + column;
  const auto along = [](const Vec3<double>& value, const Vec3<double>& change) {
    Vec3<Dual<1>> moved{value.x, value.y, value.z};
    moved.x.v[0] = change.x;
    moved.y.v[0] = change.y;
    moved.z.v[0] = change.z;
    return moved;
  };
  const Vec3<Dual<1>> v = along(LoadVec3(at.v, i), LoadColumn(dv, i, columns));
  Vec3<double> sum{0.0, 0.0, 0.0};
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_vertex.item[k]);
    if (c.hinge) break;  // faces come first
    const Face& face = cloth.faces[c.element];
    Vec3<Dual<1>> corner[3];
#pragma unroll
    for (int a = 0; a < 3; ++a)
      corner[a] = along(LoadVec3(at.x, face.vertex[a]), LoadColumn(dx, face.vertex[a], columns));
    const auto impulse =
        AirImpulse<Dual<1>>(at.FaceDrag(face), UnitNormal(corner), v, Load<Dual<1>>(at.w, i),
                            LoadWind<Dual<1>>(at.material));
    sum += Vec3<double>{impulse.x.v[0], impulse.y.v[0], impulse.z.v[0]};
  }
  const double mass = at.material.density * cloth.vertex_area[i];
  AddToColumn(dv, i, columns, (1.0 / mass) * sum);
}

__global__ void __launch_bounds__(kElementThreads)
    AirAdjoint(ClothView cloth, ShapeBatch batch, MovingStepView step, const double* all_lambda,
               double* adj_x, double* adj_v, int columns) {
  const auto [i, column] = FindItem(columns);
  if (i >= cloth.num_vertices) return;
  const MovingSlot at = FindMovingSlot(cloth, batch, step);
  if (at.material.air_drag == 0.0) return;
  const int size = cloth.num_dofs() * columns;
  const double* lambda = RowAt(all_lambda, blockIdx.y, size) + column;
  const auto wind = LoadWind<Dual<3>>(at.material);
  Dual<3> by_x = 0.0, by_v = 0.0;  // λ·impulse, by the vertex's position and velocity
  for (int k = cloth.to_vertex.start[i]; k < cloth.to_vertex.start[i + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_vertex.item[k]);
    if (c.hinge) break;  // faces come first
    const Face& face = cloth.faces[c.element];
    Vec3<Dual<3>> corner[3];
#pragma unroll
    for (int a = 0; a < 3; ++a) {
      const Vec3<double> place = LoadVec3(at.x, face.vertex[a]);
      corner[a] = a == c.row ? Seeded<3>(place, 0) : Vec3<Dual<3>>{place.x, place.y, place.z};
    }
    const Dual<3> drag = at.FaceDrag(face);
    const Vec3<Dual<3>> n = UnitNormal(corner), still{n.x.a, n.y.a, n.z.a};
#pragma unroll
    for (int a = 0; a < 3; ++a) {
      const int j = face.vertex[a];
      by_x += Dot(AirImpulse(drag, n, Load<Dual<3>>(at.v, j), Load<Dual<3>>(at.w, j), wind),
                  LoadColumn(lambda, j, columns));
    }
    by_v +=
        Dot(AirImpulse(drag, still, Seeded<3>(LoadVec3(at.v, i), 0), Load<Dual<3>>(at.w, i), wind),
            LoadColumn(lambda, i, columns));
  }
  AddToColumn(RowAt(adj_x, blockIdx.y, size) + column, i, columns,
              {by_x.v[0], by_x.v[1], by_x.v[2]});
  AddToColumn(RowAt(adj_v, blockIdx.y, size) + column, i, columns,
              {by_v.v[0], by_v.v[1], by_v.v[2]});
}

__global__ void LoadBefore(const HistorySlot* history, const double* start_v, const int* step,
                           double* v, int dofs) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  if (i >= dofs) return;
  const HistorySlot& from = history[blockIdx.y];
  const std::int64_t at = 1LL * blockIdx.y * dofs + i;
  v[at] = *step == 0 ? start_v[at] : from.v[(*step - 1) * from.stride + i];
}

}  // namespace

void LaunchLoadBefore(const LaunchContext& on, const HistorySlot* history, const double* start_v,
                      const int* step, double* v) {
  LaunchForItems(on, on.cloth.num_dofs(), LoadBefore, history, start_v, step, v,
                 on.cloth.num_dofs());
}

void LaunchDynamicsColumns(const LaunchContext& on, const MovingStepView& step,
                           const DynamicsPlace& place) {
  std::visit(
      [&](const auto& stretch, const auto& bend) {
        DynamicsColumns<<<dim3(BlocksFor(on.cloth.num_vertices), on.batch.slots), kElementThreads,
                          0, on.stream>>>(on.cloth, on.batch, stretch, bend, step, place);
      },
      on.law.stretch, on.law.bend);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchDynamicsGradient(const LaunchContext& on, const double* numbers, const double* lambda,
                            double* gradient, int columns) {
  DynamicsGradient<<<dim3(on.batch.slots, columns), kReduceThreads, 0, on.stream>>>(
      numbers, lambda, on.cloth.num_dofs(), columns, gradient);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchAddAirTangent(const LaunchContext& on, const MovingStepView& step, const double* dx,
                         double* dv, int columns) {
  LaunchForItems(on, on.cloth.num_vertices * columns, AirTangent, on.cloth, on.batch, step, dx, dv,
                 columns);
}

void LaunchAddAirAdjoint(const LaunchContext& on, const MovingStepView& step, const double* lambda,
                         double* adj_x, double* adj_v, int columns) {
  LaunchForItems(on, on.cloth.num_vertices * columns, AirAdjoint, on.cloth, on.batch, step, lambda,
                 adj_x, adj_v, columns);
}

}  // namespace drape
