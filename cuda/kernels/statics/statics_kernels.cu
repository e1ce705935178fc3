// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/element_kernels.h"
#include "cuda/kernels/reduce.cuh"
#include "cuda/kernels/statics/statics_kernels.h"

namespace drape {
namespace {

__global__ void __launch_bounds__(kElementThreads)
    GatherStiffness(ClothView cloth, ShapeBatch batch, DerivativeRecords all_records,
                    StiffnessTerms terms, double* matrix) {
  const int item = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (item >= cloth.num_entries) return;
  const int entry = cloth.entry_order[item], rollout = RolloutAt(batch, slot);
  const DerivativeRecords records = all_records.From(cloth, slot);
  const std::int64_t stress0 = static_cast<std::int64_t>(rollout) * cloth.num_faces;
  const double shift = terms.mu[slot] * batch.material[rollout].density;
  const double tension = shift * terms.length * terms.length;
  double block[9] = {}, isotropic = 0.0;
  for (int k = cloth.to_entry.start[entry]; k < cloth.to_entry.start[entry + 1]; ++k) {
    const Contribution c = Unpack(cloth.to_entry.item[k]);
    if (c.hinge) {
      const double* at_ab = records.hinges[c.element].block[c.row][c.column];
      const double* at_ba = records.hinges[c.element].block[c.column][c.row];
#pragma unroll
      for (int n = 0; n < 9; ++n) block[n] -= 0.5 * (at_ab[n] + at_ba[3 * (n % 3) + n / 3]);
      continue;
    }
    const Face& face = cloth.faces[c.element];
    const CornerGradient a = GradientOf(face, c.row), b = GradientOf(face, c.column);
    double at_ab[9] = {}, at_ba[9] = {};
    AddFaceBlock(face, records.faces[c.element].Q, c.row, c.column, at_ab);
    AddFaceBlock(face, records.faces[c.element].Q, c.column, c.row, at_ba);
#pragma unroll
    for (int n = 0; n < 9; ++n) block[n] -= 0.5 * (at_ab[n] + at_ba[3 * (n % 3) + n / 3]);
    StretchStress<double> change{tension, tension, 0.0};
    if (terms.stress != nullptr) {
      const StretchStress<double>& geometric = terms.geometric[stress0 + c.element];
      const StretchStress<double>& stress = terms.stress[stress0 + c.element];
      change.uu += geometric.uu - stress.uu;
      change.vv += geometric.vv - stress.vv;
      change.uv += geometric.uv - stress.uv;
    }
    isotropic += face.area * GeometricWeight(change, a.u, a.v, b.u, b.v);
  }
  const FrontEntry& place = cloth.entries[entry];
  if (place.row == place.column)
    isotropic += cloth.handle[place.row] + shift * cloth.vertex_area[place.row];
  block[0] += isotropic;
  block[4] += isotropic;
  block[8] += isotropic;
  double* to = matrix + 9 * (static_cast<std::int64_t>(slot) * cloth.num_entries + entry);
#pragma unroll
  for (int n = 0; n < 9; ++n) to[n] = block[n];
}

// Energy of what acts on one vertex.
__device__ double VertexEnergy(const ClothView& cloth, const MaterialView& material,
                               const double* x, int i) {
  const Vec3<double> at = LoadVec3(x, i), away = at - LoadVec3(cloth.rest_x, i);
  const Vec3<double> gravity{cloth.gravity[0], cloth.gravity[1], cloth.gravity[2]};
  return 0.5 * cloth.handle[i] * Dot(away, away) - Dot(LoadVec3(cloth.load, i), at) -
         material.density * cloth.vertex_area[i] * Dot(gravity, at);
}

// One block a slot; the forces are there already.
template <class BendLaw>
__global__ void __launch_bounds__(kReduceThreads)
    Measure(ClothView cloth, ShapeBatch batch, BendLaw bend, StepRecords records, Shapes shapes,
            double* sums) {
  const int slot = blockIdx.x, rollout = RolloutAt(batch, slot);
  const MaterialView& material = batch.material[rollout];
  const double* x = RowAt(shapes.x, rollout, cloth.num_dofs());
  const double* force = RowAt(shapes.force, rollout, cloth.num_dofs());
  const FaceRecord* faces = records.From(cloth, slot).faces;
  StretchStress<double>* stress = RowAt(shapes.stress, rollout, cloth.num_faces);
  double energy = 0.0, square = 0.0;
  for (int f = threadIdx.x; f < cloth.num_faces; f += kReduceThreads) {
    stress[f] = Stress(faces[f].k, faces[f].k.G);
    energy += cloth.faces[f].area * StretchEnergy(stress[f], faces[f].k.G);
  }
  for (int e = threadIdx.x; e < cloth.num_hinges; e += kReduceThreads)
    energy += BendEnergy(bend, cloth.hinges[e], BendTableAt(material, e),
                         DihedralAngle(GatherCorners(cloth.hinges[e], x)));
  for (int i = threadIdx.x; i < cloth.num_vertices; i += kReduceThreads) {
    energy += VertexEnergy(cloth, material, x, i);
    const Vec3<double> f = LoadVec3(force, i);
    square += Dot(f, f);
  }
  square = SumOfBlock(square);
  energy = SumOfBlock(energy);
  if (threadIdx.x == 0) {
    sums[2 * slot] = square;
    sums[2 * slot + 1] = energy;
  }
}

__global__ void GatherRows(int dofs, const int* rollout, const double* from, double* to) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i < dofs) RowAt(to, slot, dofs)[i] = RowAt(from, rollout[slot], dofs)[i];
}

__global__ void ScatterRows(int dofs, const int* rollout, const double* from, double* to) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i < dofs) RowAt(to, rollout[slot], dofs)[i] = RowAt(from, slot, dofs)[i];
}

__global__ void __launch_bounds__(kReduceThreads)
    LargestMove(int dofs, const double* dx, double* move) {
  const double* from = dx + static_cast<std::int64_t>(blockIdx.x) * dofs;
  double largest = 0.0;
  for (int i = threadIdx.x; i < dofs; i += kReduceThreads) {
    const double size = fabs(from[i]);
    if (size > largest || size != size) largest = size;
  }
  largest = LargestOfBlock(largest);
  if (threadIdx.x == 0) move[blockIdx.x] = largest;
}

template <class StretchLaw>
__global__ void __launch_bounds__(kElementThreads)
    ExtrapolateStress(ClothView cloth, ShapeBatch batch, StretchLaw law, const double* all_dx,
                      const double* scales, StretchStress<double>* geometric) {
  const int f = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (f >= cloth.num_faces) return;
  const int rollout = RolloutAt(batch, slot);
  const Face& face = cloth.faces[f];
  const DeformationGradient<double> F =
      GatherColumns(face, RowAt(batch.x, rollout, cloth.num_dofs()));
  DeformationGradient<double> dF = GatherColumns(face, RowAt(all_dx, slot, cloth.num_dofs()));
  dF = {scales[slot] * dF.u, scales[slot] * dF.v};
  RowAt(geometric, rollout, cloth.num_faces)[f] = ExtrapolatedStress(
      StressByStrain(law, Green(F), StretchTableAt(batch.material[rollout], f)), StrainRate(F, dF));
}

__global__ void AddStep(int dofs, ShapeBatch batch, const double* dx, const double* scales,
                        double* x) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i < dofs)
    RowAt(x, RolloutAt(batch, slot), dofs)[i] += scales[slot] * RowAt(dx, slot, dofs)[i];
}

__global__ void ActOnShapes(ClothView cloth, ShapeBatch batch, const ShapeAction* actions,
                            Shapes here, Shapes best, StretchStress<double>* geometric) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  const ShapeAction action = actions[slot];
  if (action == ShapeAction::kGoOn) return;
  const int rollout = RolloutAt(batch, slot);
  const Shapes& from = action == ShapeAction::kKeep ? here : best;
  const Shapes& to = action == ShapeAction::kKeep ? best : here;
  const std::int64_t dofs = static_cast<std::int64_t>(rollout) * cloth.num_dofs();
  if (i < cloth.num_dofs()) {
    to.x[dofs + i] = from.x[dofs + i];
    to.force[dofs + i] = from.force[dofs + i];
  }
  if (i < cloth.num_faces) {
    const std::int64_t f = static_cast<std::int64_t>(rollout) * cloth.num_faces + i;
    to.stress[f] = geometric[f] = from.stress[f];
  }
}

// Vectors of the solves with a slightly unsymmetric stiffness (CgwRecurrence).

// A block has one column of one slot.
__global__ void __launch_bounds__(kReduceThreads)
    ColumnDots(int dofs, const double* a, const double* b, double* dots, int columns) {
  const int j = blockIdx.x, slot = blockIdx.y;
  const std::int64_t first = static_cast<std::int64_t>(slot) * dofs * columns + j;
  double sum = 0.0;
  for (int i = threadIdx.x; i < dofs; i += kReduceThreads) {
    const std::int64_t at = first + static_cast<std::int64_t>(i) * columns;
    sum += a[at] * b[at];
  }
  sum = SumOfBlock(sum);
  if (threadIdx.x == 0) dots[slot * columns + j] = sum;
}

__global__ void CgwAdvance(int dofs, const double* weights, const double* step, double* before,
                           double* x, int columns) {
  const std::int64_t i = static_cast<std::int64_t>(blockIdx.x) * blockDim.x + threadIdx.x;
  const std::int64_t count = static_cast<std::int64_t>(dofs) * columns;
  if (i >= count) return;
  const double weight = weights[blockIdx.y * columns + i % columns];
  if (weight < 0.0) return;
  const std::int64_t at = blockIdx.y * count + i;
  const double now = x[at], old = before[at];
  x[at] = old + weight * (step[at] + now - old);
  before[at] = now;
}

__global__ void __launch_bounds__(kReduceThreads)
    PowerStep(int dofs, double* all_images, double* all_directions, double* radius) {
  double* image = RowAt(all_images, blockIdx.x, dofs);
  double* direction = RowAt(all_directions, blockIdx.x, dofs);
  double old_square = 0.0, square = 0.0;
  for (int i = threadIdx.x; i < dofs; i += kReduceThreads) {
    image[i] += direction[i];
    old_square += direction[i] * direction[i];
    square += image[i] * image[i];
  }
  old_square = SumOfBlock(old_square);
  square = SumOfBlock(square);
  const bool grows = square > 0.0;
  const double scale = grows ? 1.0 / ::sqrt(square) : 0.0;
  for (int i = threadIdx.x; i < dofs; i += kReduceThreads) {
    direction[i] = scale * image[i];
    image[i] = 0.0;
  }
  if (threadIdx.x == 0) radius[blockIdx.x] = grows ? ::sqrt(square / old_square) : 0.0;
}

}  // namespace

void LaunchGatherStiffness(const LaunchContext& on, const DerivativeRecords& records,
                           const StiffnessTerms& terms, double* matrix) {
  LaunchForItems(on, on.cloth.num_entries, GatherStiffness, on.cloth, on.batch, records, terms,
                 matrix);
  LaunchAddContactStiffness(on, matrix);
}

void LaunchMeasure(const LaunchContext& on, const StepRecords& records, const Shapes& shapes,
                   double* sums) {
  std::visit(
      [&](const auto& bend) {
        Measure<<<on.batch.slots, kReduceThreads, 0, on.stream>>>(on.cloth, on.batch, bend, records,
                                                                  shapes, sums);
      },
      on.law.bend);
  CUDA_CHECK(cudaGetLastError());
  LaunchAddContactEnergy(on, sums);
}

void LaunchGatherRows(const LaunchContext& on, const double* from, double* to) {
  const int dofs = on.cloth.num_dofs();
  LaunchForItems(on, dofs, GatherRows, dofs, on.batch.rollout, from, to);
}

void LaunchScatterRows(const LaunchContext& on, const double* from, double* to) {
  const int dofs = on.cloth.num_dofs();
  LaunchForItems(on, dofs, ScatterRows, dofs, on.batch.rollout, from, to);
}

void LaunchLargestMove(const LaunchContext& on, const double* dx, double* move) {
  LargestMove<<<on.batch.slots, kReduceThreads, 0, on.stream>>>(on.cloth.num_dofs(), dx, move);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchMoveShapes(const LaunchContext& on, const double* dx, const double* scale,
                      StretchStress<double>* geometric, double* x) {
  if (on.cloth.num_faces > 0)
    std::visit(
        [&](const auto& stretch) {
          const dim3 grid(BlocksFor(on.cloth.num_faces), on.batch.slots);
          ExtrapolateStress<<<grid, kElementThreads, 0, on.stream>>>(on.cloth, on.batch, stretch,
                                                                     dx, scale, geometric);
        },
        on.law.stretch);
  CUDA_CHECK(cudaGetLastError());
  const int dofs = on.cloth.num_dofs();
  LaunchForItems(on, dofs, AddStep, dofs, on.batch, dx, scale, x);
}

void LaunchShapeAction(const LaunchContext& on, const ShapeAction* action, const Shapes& here,
                       const Shapes& best, StretchStress<double>* geometric) {
  const int count =
      on.cloth.num_dofs() > on.cloth.num_faces ? on.cloth.num_dofs() : on.cloth.num_faces;
  LaunchForItems(on, count, ActOnShapes, on.cloth, on.batch, action, here, best, geometric);
}

void LaunchColumnDots(const LaunchContext& on, const double* a, const double* b, double* dots,
                      int columns) {
  ColumnDots<<<dim3(columns, on.batch.slots), kReduceThreads, 0, on.stream>>>(on.cloth.num_dofs(),
                                                                              a, b, dots, columns);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchCgwAdvance(const LaunchContext& on, const double* weight, const double* step,
                      double* before, double* x, int columns) {
  const int dofs = on.cloth.num_dofs();
  LaunchForItems(on, dofs * columns, CgwAdvance, dofs, weight, step, before, x, columns);
}

void LaunchCopy(const double* from, double* to, std::int64_t count, cudaStream_t stream) {
  CUDA_CHECK(cudaMemcpyAsync(to, from, count * sizeof(double), cudaMemcpyDeviceToDevice, stream));
}

void LaunchPowerStep(const LaunchContext& on, double* image, double* direction, double* radius) {
  PowerStep<<<on.batch.slots, kReduceThreads, 0, on.stream>>>(on.cloth.num_dofs(), image, direction,
                                                              radius);
  CUDA_CHECK(cudaGetLastError());
}

}  // namespace drape
