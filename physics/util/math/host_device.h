// SPDX-License-Identifier: Apache-2.0
#pragma once

// DRAPE_HD marks the pure functions that both the CPU loops and the CUDA kernels call. DRAPE_INLINE
// marks those that compile to a few instructions, because g++ does not inline them in the element
// loops (measured: derivatives take twice as long).
#ifdef __CUDACC__
#define DRAPE_HD __host__ __device__
#define DRAPE_INLINE __host__ __device__ __forceinline__
#else
#define DRAPE_HD
#define DRAPE_INLINE inline __attribute__((always_inline))
#endif
