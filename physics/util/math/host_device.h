// SPDX-License-Identifier: Apache-2.0
#pragma once

// DRAPE_HD marks the pure functions that both the CPU loops and the CUDA kernels call. DRAPE_INLINE
// marks those of a few instructions: g++ leaves calls of them in the element loops (measured: twice
// the time of the derivatives).
#ifdef __CUDACC__
#define DRAPE_HD __host__ __device__
#define DRAPE_INLINE __host__ __device__ __forceinline__
#else
#define DRAPE_HD
#define DRAPE_INLINE inline __attribute__((always_inline))
#endif
