// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace drape {

// OpenBLAS picks its kernels by CPU when it is loaded, and a version older than the CPU falls back
// to kernels without AVX (measured: 10.7 instead of 89 Gflop/s).

// The kernel set in use ("Zen", "Haswell", "Prescott", …); empty when the BLAS is not OpenBLAS.
std::string BlasCore();

// The kernel set that this CPU should have, when the one in use is slower; else empty.
std::string BetterBlasCore();

// Call first in main(): when a better kernel set is known, sets OPENBLAS_CORETYPE and starts the
// program again in the same process. Returns when nothing is to be done. A value that the user has
// set is left alone.
void EnsureFastBlas(char** argv);

// Rollouts are the unit of parallelism: one BLAS thread each.
void UseOneBlasThread();

}  // namespace drape
