// SPDX-License-Identifier: Apache-2.0
#include "cuda/kernels/element_kernels.cuh"
#include "cuda/kernels/element_kernels.h"
#include "cuda/kernels/reduce.cuh"

namespace drape {
namespace {

// The vertex of a thread: number, slot, rollout, rest area [m²], place [m].
struct ContactVertex {
  int i, slot, rollout;
  double area;
  Vec3<double> x;
};
__device__ __forceinline__ bool FindVertex(const ClothView& cloth, const ShapeBatch& batch,
                                           ContactVertex* vertex) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x, slot = blockIdx.y;
  if (i >= cloth.num_vertices) return false;
  const int rollout = RolloutAt(batch, slot);
  *vertex = {i, slot, rollout, cloth.vertex_area[i],
             LoadVec3(RowAt(batch.x, rollout, cloth.num_dofs()), i)};
  return true;
}

__device__ __forceinline__ void AddBlock(const double (&block)[9], double* to) {
#pragma unroll
  for (int n = 0; n < 9; ++n) to[n] += block[n];
}
// The block of the vertex itself, on the diagonal of a slot's matrix.
__device__ __forceinline__ double* DiagonalEntry(const ClothView& cloth, const ContactVertex& at,
                                                 double* matrix) {
  return matrix +
         9 * (static_cast<std::int64_t>(at.slot) * cloth.num_entries + cloth.diagonal_entry[at.i]);
}

template <class Contact>
__global__ void __launch_bounds__(kElementThreads)
    PushOutVertices(ClothView cloth, ShapeBatch batch, double* x) {
  ContactVertex at;
  if (!FindVertex(cloth, batch, &at)) return;
  Vec3<double> place = at.x;
  if (!PushVertexOut(Contact(cloth.contact), place)) return;
  StoreVec3(RowAt(x, at.rollout, cloth.num_dofs()), at.i, place);
}

template <class Contact>
__global__ void __launch_bounds__(kElementThreads)
    AddContactStep(ClothView cloth, ShapeBatch batch, double h, double* matrix, double* rhs) {
  ContactVertex at;
  if (!FindVertex(cloth, batch, &at)) return;
  double block[9] = {};
  AddVertexStepStiffness(Contact(cloth.contact), at.area, at.x, h * h, block);
  AddBlock(block, DiagonalEntry(cloth, at, matrix));
  if (rhs != nullptr)
    AddTo(RowAt(rhs, at.slot, cloth.num_dofs()), at.i,
          h * VertexForce(Contact(cloth.contact), at.area, at.x));
}

template <class Contact>
__global__ void __launch_bounds__(kElementThreads)
    AddContactForce(ClothView cloth, ShapeBatch batch, double* force) {
  ContactVertex at;
  if (!FindVertex(cloth, batch, &at)) return;
  AddTo(RowAt(force, at.rollout, cloth.num_dofs()), at.i,
        VertexForce(Contact(cloth.contact), at.area, at.x));
}

// One block a slot.
template <class Contact>
__global__ void __launch_bounds__(kReduceThreads)
    AddContactEnergy(ClothView cloth, ShapeBatch batch, double* sums) {
  const int slot = blockIdx.x;
  const double* x = RowAt(batch.x, RolloutAt(batch, slot), cloth.num_dofs());
  double energy = 0.0;
  for (int i = threadIdx.x; i < cloth.num_vertices; i += kReduceThreads)
    energy += VertexEnergy(Contact(cloth.contact), cloth.vertex_area[i], LoadVec3(x, i));
  energy = SumOfBlock(energy);
  if (threadIdx.x == 0) sums[2 * slot + 1] += energy;
}

template <class Contact>
__global__ void __launch_bounds__(kElementThreads)
    AddContactStiffness(ClothView cloth, ShapeBatch batch, double* matrix) {
  ContactVertex at;
  if (!FindVertex(cloth, batch, &at)) return;
  double negative[9] = {};
  AddVertexStepDerivative(Contact(cloth.contact), at.area, at.x, {0.0, 0.0, 0.0}, 1.0, negative);
  double* to = DiagonalEntry(cloth, at, matrix);
#pragma unroll
  for (int n = 0; n < 9; ++n) to[n] -= negative[n];
}

template <class Contact>
__global__ void __launch_bounds__(kElementThreads)
    AddContactDerivative(ClothView cloth, ShapeBatch batch, const double* w, double h,
                         double* blocks) {
  ContactVertex at;
  if (!FindVertex(cloth, batch, &at)) return;
  double block[9] = {};
  AddVertexStepDerivative(Contact(cloth.contact), at.area, at.x,
                          LoadVec3(RowAt(w, at.slot, cloth.num_dofs()), at.i), h, block);
  const std::int64_t b = cloth.entry_block[cloth.diagonal_entry[at.i]];
  AddBlock(block, blocks + 9 * (static_cast<std::int64_t>(at.slot) * cloth.num_blocks + b));
}

template <class Contact>
__global__ void __launch_bounds__(kElementThreads)
    AddContactAdjoint(ClothView cloth, ShapeBatch batch, const double* w, double h,
                      const double* lambda, double* adj_x) {
  ContactVertex at;
  if (!FindVertex(cloth, batch, &at)) return;
  double block[9] = {};
  AddVertexStepDerivative(Contact(cloth.contact), at.area, at.x,
                          LoadVec3(RowAt(w, at.slot, cloth.num_dofs()), at.i), h, block);
  const Vec3<double> l = LoadVec3(RowAt(lambda, at.slot, cloth.num_dofs()), at.i);
  AddTo(RowAt(adj_x, at.slot, cloth.num_dofs()), at.i,
        {block[0] * l.x + block[3] * l.y + block[6] * l.z,
         block[1] * l.x + block[4] * l.y + block[7] * l.z,
         block[2] * l.x + block[5] * l.y + block[8] * l.z});
}

template <class Contact>
__global__ void __launch_bounds__(kElementThreads)
    ShortenVertexMoves(ClothView cloth, ShapeBatch batch, MoveScale scale, double* direction,
                       int* blocked) {
  ContactVertex at;
  if (!FindVertex(cloth, batch, &at)) return;
  const double length = scale.by_slot == nullptr ? scale.scale : scale.by_slot[at.slot];
  double* to = RowAt(direction, at.slot, cloth.num_dofs()) + 3 * at.i;
  const double share =
      SafeShare(Contact(cloth.contact), at.x, {length * to[0], length * to[1], length * to[2]});
  if (share == 1.0) return;
  for (int k = 0; k < 3; ++k) to[k] *= share;
  if (blocked != nullptr) blocked[at.slot] = 1;
}

// Launches a thread for each vertex, or nothing without obstacles.
template <class Kernel, class... Arguments>
void LaunchForVertices(const LaunchContext& on, const Kernel& for_formulas, const Kernel& for_all,
                       Arguments... arguments) {
  if (on.cloth.contact.count == 0) return;
  const Kernel& kernel = on.cloth.contact.has_meshes ? for_all : for_formulas;
  LaunchForItems(on, on.cloth.num_vertices, kernel, on.cloth, on.batch, arguments...);
}

}  // namespace

void LaunchPushOut(const LaunchContext& on, double* x) {
  LaunchForVertices(on, PushOutVertices<FormulaContact>, PushOutVertices<SolidContact>, x);
}

void LaunchAddContactStep(const LaunchContext& on, double h, double* matrix, double* rhs) {
  LaunchForVertices(on, AddContactStep<FormulaContact>, AddContactStep<SolidContact>, h, matrix,
                    rhs);
}

void LaunchAddContactForce(const LaunchContext& on, double* force) {
  LaunchForVertices(on, AddContactForce<FormulaContact>, AddContactForce<SolidContact>, force);
}

void LaunchAddContactEnergy(const LaunchContext& on, double* sums) {
  if (on.cloth.contact.count == 0) return;
  const auto kernel = on.cloth.contact.has_meshes ? AddContactEnergy<SolidContact>
                                                  : AddContactEnergy<FormulaContact>;
  kernel<<<on.batch.slots, kReduceThreads, 0, on.stream>>>(on.cloth, on.batch, sums);
  CUDA_CHECK(cudaGetLastError());
}

void LaunchAddContactStiffness(const LaunchContext& on, double* matrix) {
  LaunchForVertices(on, AddContactStiffness<FormulaContact>, AddContactStiffness<SolidContact>,
                    matrix);
}

void LaunchAddContactDerivative(const LaunchContext& on, const double* w, double h,
                                double* blocks) {
  LaunchForVertices(on, AddContactDerivative<FormulaContact>, AddContactDerivative<SolidContact>, w,
                    h, blocks);
}

void LaunchAddContactAdjoint(const LaunchContext& on, const double* w, double h,
                             const double* lambda, double* adj_x) {
  LaunchForVertices(on, AddContactAdjoint<FormulaContact>, AddContactAdjoint<SolidContact>, w, h,
                    lambda, adj_x);
}

void LaunchShortenMoves(const LaunchContext& on, MoveScale scale, double* direction, int* blocked) {
  LaunchForVertices(on, ShortenVertexMoves<FormulaContact>, ShortenVertexMoves<SolidContact>, scale,
                    direction, blocked);
}

}  // namespace drape
