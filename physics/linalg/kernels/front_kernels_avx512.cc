// SPDX-License-Identifier: Apache-2.0
// Compiled with AVX-512; runs only where ChosenFrontKernels has seen that the machine has it.
#include "physics/linalg/kernels/front_kernels.h"
#include "physics/linalg/kernels/front_kernels_impl.h"

namespace drape {
const FrontKernels kAvx512FrontKernels = MakeFrontKernels<Vec8>("avx512");

}  // namespace drape
