// SPDX-License-Identifier: Apache-2.0
#include "cuda/engine/cuda_backend.h"

namespace drape {
namespace {

constexpr char kHow[] = "built without it, configure with the preset cuda (needs nvcc)";

}  // namespace

// NOLINTNEXTLINE(performance-unnecessary-value-param): as cuda_backend.cc has it
std::unique_ptr<Backend> MakeCudaBackend(std::shared_ptr<const ClothModel>, int) {
  throw NotCompiled("cuda", kHow);
}

std::unique_ptr<LinearSolver> MakeCudaSolver(const BlockPattern&) {
  throw NotCompiled("cuda", kHow);
}

CudaSurvey SurveyCuda() { return {false, kHow}; }

void WakeCuda() {}

}  // namespace drape
