// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/linalg/kernels/front_kernels.h"

namespace drape {

// Defined in front_kernels_avx512.cc, where the build has it (DRAPE_AVX512_KERNELS).
extern const FrontKernels kAvx512FrontKernels;

}  // namespace drape
