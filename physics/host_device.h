// SPDX-License-Identifier: Apache-2.0
#pragma once

// Marks the pure functions that both the CPU loops and the CUDA kernels call.
#ifdef __CUDACC__
#define DRAPE_HD __host__ __device__
#else
#define DRAPE_HD
#endif
