// SPDX-License-Identifier: Apache-2.0
#include "physics/linalg/kernels/front_kernels.h"

#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "physics/linalg/kernels/front_kernels_impl.h"

namespace drape {
namespace {

// For the machine that the rest of the build is compiled for.
constexpr FrontKernels kBaselineFrontKernels = MakeFrontKernels<Vec4>("baseline");

const FrontKernels& ChooseFrontKernels() {
  const std::vector<const FrontKernels*>& available = AvailableFrontKernels();
  const char* wanted = std::getenv("DRAPE_VECTORS");
  if (wanted == nullptr || *wanted == '\0') return *available.back();
  std::string names;
  for (const FrontKernels* kernels : available) {
    if (std::string(wanted) == kernels->name) return *kernels;
    names += std::string(names.empty() ? "" : ", ") + kernels->name;
  }
  throw std::invalid_argument("DRAPE_VECTORS: " + std::string(wanted) + ", expected one of " +
                              names + " on this machine");
}

}  // namespace

const std::vector<const FrontKernels*>& AvailableFrontKernels() {
  static const std::vector<const FrontKernels*> available = [] {
    std::vector<const FrontKernels*> list = {&kBaselineFrontKernels};
#ifdef DRAPE_AVX512_KERNELS
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512bw"))
      list.push_back(&kAvx512FrontKernels);
#endif
    return list;
  }();
  return available;
}

const FrontKernels& ChosenFrontKernels() {
  static const FrontKernels& chosen = ChooseFrontKernels();
  return chosen;
}

}  // namespace drape
