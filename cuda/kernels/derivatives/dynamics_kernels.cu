// SPDX-License-Identifier: Apache-2.0
// Gradients by density, damping and drag: a block of threads has one slot and one right-hand side,
// and adds vertices, faces and hinges in a fixed order.
#include "cuda/kernels/derivatives/sensitivity_kernels.h"
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/reduce.cuh"
#include "physics/cloth/assembly/air_element.h"

namespace drape {
namespace {

// A slot's step, and one column of λ.
struct DampedSlot {
  const double *x, *v, *w, *lambda;
  int columns;
  double h;

  __device__ Vec3<double> LambdaAt(int i) const {
    const double* at = lambda + 3LL * i * columns;
    return {at[0], at[columns], at[2 * columns]};
  }
};
// λ · the columns of a thread's vertices and elements, as DynamicsColumns has them.
struct DampedSums {
  double density = 0.0, mass = 0.0, stiffness = 0.0, drag = 0.0;
};

__device__ void AddVertex(const ClothView& cloth, const MaterialView& material,
                          const DampedSlot& at, int i, DampedSums& sums) {
  const Vec3<double> l = at.LambdaAt(i);
  const double area = cloth.vertex_area[i], along_w = Dot(l, LoadVec3(at.w, i));
  const Vec3<double> gravity{cloth.gravity[0], cloth.gravity[1], cloth.gravity[2]};
  sums.density += area * (Dot(l, LoadVec3(at.v, i)) -
                          (1.0 + at.h * material.mass_damping) * along_w + at.h * Dot(l, gravity));
  sums.mass -= at.h * material.density * area * along_w;
}

template <class Law>
__device__ void AddFace(const ClothView& cloth, const MaterialView& material, const Law& law,
                        const DampedSlot& at, int f, DampedSums& sums) {
  const Face& face = cloth.faces[f];
  const DeformationGradient<double> F = GatherColumns(face, at.x);
  const auto k = EvaluateStretch(law, Green(F), StretchTableAt(material, f));
  const auto Hw = StretchStiffnessTimes(k, F, GatherColumns(face, at.w));
  const ShapeGradient shape = GradientOf(face);
  const Vec3<double> corner[3] = {LoadVec3(at.x, face.vertex[0]), LoadVec3(at.x, face.vertex[1]),
                                  LoadVec3(at.x, face.vertex[2])};
  const Vec3<double> n = UnitNormal(corner);
  const Vec3<double> wind{material.wind[0], material.wind[1], material.wind[2]};
#pragma unroll
  for (int a = 0; a < 3; ++a) {
    const int i = face.vertex[a];
    const Vec3<double> l = at.LambdaAt(i);
    sums.stiffness -= at.h * face.area * (shape.u[a] * Dot(Hw.u, l) + shape.v[a] * Dot(Hw.v, l));
    sums.drag +=
        Dot(AirImpulse(at.h * face.area / 3.0, n, LoadVec3(at.v, i), LoadVec3(at.w, i), wind), l);
  }
}

template <class Law>
__device__ void AddHinge(const ClothView& cloth, const MaterialView& material, const Law& law,
                         const DampedSlot& at, int e, DampedSums& sums) {
  const Hinge& hinge = cloth.hinges[e];
  const HingeCorners corners = GatherCorners(hinge, at.x);
  const double theta = DihedralAngle(corners);
  const HingeGradient d = AngleGradient(EvaluateWings(corners));
  double along_lambda = 0.0;
#pragma unroll
  for (int a = 0; a < 4; ++a) along_lambda += Dot(d.d[a], at.LambdaAt(hinge.vertex[a]));
  sums.stiffness -= at.h * HingeStiffness(law, hinge, BendTableAt(material, e), theta) *
                    law.Measure(theta).slope * Dot(d, GatherCorners(hinge, at.w)) * along_lambda;
}

template <class StretchLaw, class BendLaw>
__global__ void __launch_bounds__(kReduceThreads)
    DynamicsGradient(ClothView cloth, ShapeBatch batch, StretchLaw stretch, BendLaw bend,
                     const double* v, const double* w, double h, const double* lambda, int columns,
                     double* gradient) {
  const int slot = blockIdx.x, j = blockIdx.y, rollout = RolloutAt(batch, slot);
  const int dofs = cloth.num_dofs();
  const MaterialView& material = batch.material[rollout];
  const DampedSlot at{RowAt(batch.x, rollout, dofs),
                      RowAt(v, slot, dofs),
                      RowAt(w, slot, dofs),
                      RowAt(lambda, slot, dofs * columns) + j,
                      columns,
                      h};
  DampedSums sums;
  for (int i = threadIdx.x; i < cloth.num_vertices; i += kReduceThreads)
    AddVertex(cloth, material, at, i, sums);
  for (int f = threadIdx.x; f < cloth.num_faces; f += kReduceThreads)
    AddFace(cloth, material, stretch, at, f, sums);
  for (int e = threadIdx.x; e < cloth.num_hinges; e += kReduceThreads)
    AddHinge(cloth, material, bend, at, e, sums);
  const double all[4] = {SumOfBlock(sums.density), SumOfBlock(sums.mass),
                         SumOfBlock(sums.stiffness), SumOfBlock(sums.drag)};
  if (threadIdx.x != 0) return;
  double* to = gradient + 4LL * slot * columns + j;
#pragma unroll
  for (int k = 0; k < 4; ++k) to[k * columns] += all[k];
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

void LaunchDynamicsGradient(const LaunchContext& on, const double* v, const double* w, double h,
                            const double* lambda, double* gradient, int columns) {
  std::visit(
      [&](const auto& stretch, const auto& bend) {
        DynamicsGradient<<<dim3(on.batch.slots, columns), kReduceThreads, 0, on.stream>>>(
            on.cloth, on.batch, stretch, bend, v, w, h, lambda, columns, gradient);
      },
      on.law.stretch, on.law.bend);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
