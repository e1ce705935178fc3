// SPDX-License-Identifier: Apache-2.0
#include "physics/blas.h"

#include <dlfcn.h>
#include <glog/logging.h>
#include <unistd.h>

#include <array>
#include <cstdlib>

namespace drape {
namespace {

// A function of the loaded BLAS, or nullptr: the library may be another BLAS.
template <class Function>
Function* FindBlasFunction(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

bool HasSlowKernels(const std::string& core) {
  constexpr std::array kBeforeAvx = {"Prescott", "Core2",   "Penryn",    "Dunnington", "Nehalem",
                                     "Athlon",   "Opteron", "Barcelona", "Bobcat",     "Atom",
                                     "Nano",     "Katmai",  "Coppermine", "Northwood", "Banias",
                                     "Sandybridge", "generic"};
  for (const char* slow : kBeforeAvx)
    if (core.rfind(slow, 0) == 0) return true;
  return false;
}

}  // namespace

std::string BlasCore() {
  const auto name = FindBlasFunction<char*()>("openblas_get_corename");
  return name == nullptr ? std::string() : std::string(name());
}

std::string BetterBlasCore() {
#if defined(__x86_64__)
  if (!HasSlowKernels(BlasCore()) || !__builtin_cpu_supports("avx2")) return {};
  return __builtin_cpu_supports("avx512vl") ? "SkylakeX" : "Haswell";
#else
  return {};
#endif
}

void EnsureFastBlas(char** argv) {
  const std::string better = BetterBlasCore();
  if (better.empty() || std::getenv("OPENBLAS_CORETYPE") != nullptr) return;
  setenv("OPENBLAS_CORETYPE", better.c_str(), 1);
  execv("/proc/self/exe", argv);
  LOG(WARNING) << "OpenBLAS uses its " << BlasCore() << " kernels; set OPENBLAS_CORETYPE=" << better
               << " to make the factorisations several times faster";
}

void UseOneBlasThread() {
  if (const auto set_threads = FindBlasFunction<void(int)>("openblas_set_num_threads"))
    set_threads(1);
}

}  // namespace drape
