// SPDX-License-Identifier: Apache-2.0
#include <benchmark/benchmark.h>

#include "physics/blas.h"

int main(int argc, char** argv) {
  drape::EnsureFastBlas(argv);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
