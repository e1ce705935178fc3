// SPDX-License-Identifier: Apache-2.0
// The stages of outlines and soft silhouettes: a thread has one item of one slot. Compiled without
// fused products: sides of edges and crossings must be the same numbers in each kernel.
#include "cuda/device/cuda_error.h"
#include "cuda/readout/read_kernels.h"
#include "cuda/readout/silhouette_run.h"

namespace drape {
namespace {

constexpr int kThreads = 128, kScanThreads = 256, kWarps = kScanThreads / 32;

template <class Plan, class Slot, class Stage>
__global__ void __launch_bounds__(kThreads)
    RunStage(Plan plan, const Slot* slots, Stage stage, int items) {
  const int i = blockIdx.x * blockDim.x + threadIdx.x;
  const Slot& slot = slots[blockIdx.y];
  if (i < items && *slot.status == kRead) stage(plan, slot, i);
}

// Sum of `value` over the threads before this one; *total over all.
__device__ int SumBefore(int value, int* total) {
  __shared__ int of_warp[kWarps];
  const int lane = threadIdx.x % 32, warp = threadIdx.x / 32;
  int sum = value;
  for (int step = 1; step < 32; step *= 2) {
    const int below = __shfl_up_sync(~0u, sum, step);
    if (lane >= step) sum += below;
  }
  if (lane == 31) of_warp[warp] = sum;
  __syncthreads();
  int before = sum - value;
  *total = 0;
  for (int w = 0; w < kWarps; ++w) {
    if (w < warp) before += of_warp[w];
    *total += of_warp[w];
  }
  __syncthreads();
  return before;
}

// A block has one slot.
__global__ void __launch_bounds__(kScanThreads)
    SumStarts(const SilhouetteSlot* slots, SlotStarts start, int items, int room) {
  const SilhouetteSlot& slot = slots[blockIdx.x];
  if (*slot.status != kRead) return;
  int* counts = slot.*start.member;
  int sum = 0;
  for (int first = 0; first < items; first += kScanThreads) {
    const int i = first + threadIdx.x;
    int total = 0;
    const int before = SumBefore(i < items ? counts[i] : 0, &total);
    if (i < items) counts[i] = sum + before;
    sum += total;
  }
  if (threadIdx.x > 0) return;
  counts[items] = sum;
  if (sum > room) *slot.status = kNoRoom;
}

template <class Plan, class Slot>
struct KernelRunner {
  const Plan& plan;
  const Slot* slots;
  int count;
  cudaStream_t stream;

  template <class Stage>
  void Each(Stage stage, int items) {
    if (items == 0) return;
    RunStage<<<dim3((items + kThreads - 1) / kThreads, count), kThreads, 0, stream>>>(plan, slots,
                                                                                      stage, items);
    CUDA_CHECK(cudaGetLastError());
  }
  void Scan(SlotStarts start, int items, int room) {
    SumStarts<<<count, kScanThreads, 0, stream>>>(slots, start, items, room);
    CUDA_CHECK(cudaGetLastError());
  }
};

}  // namespace

void LaunchOutlines(const OutlinePlan& plan, const OutlineSlot* slots, int count,
                    cudaStream_t stream) {
  KernelRunner<OutlinePlan, OutlineSlot> run{plan, slots, count, stream};
  RunOutlines(plan, run);
}

void LaunchOutlineLoss(const OutlinePlan& plan, const OutlineSlot* slots, int count,
                       cudaStream_t stream) {
  KernelRunner<OutlinePlan, OutlineSlot> run{plan, slots, count, stream};
  RunOutlineLoss(plan, run);
}

void LaunchCoverage(const SilhouettePlan& plan, const SilhouetteSlot* slots, int count,
                    cudaStream_t stream) {
  KernelRunner<SilhouettePlan, SilhouetteSlot> run{plan, slots, count, stream};
  RunCoverage(plan, run);
}

void LaunchSilhouetteLoss(const SilhouettePlan& plan, const SilhouetteSlot* slots, int count,
                          cudaStream_t stream) {
  KernelRunner<SilhouettePlan, SilhouetteSlot> run{plan, slots, count, stream};
  RunLoss(plan, run);
}

}  // namespace drape
