// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gmock/gmock.h>

#include "cuda/engine/cuda_backend.h"

// Skips a test where there is no device, and says why.
#define DRAPE_NEEDS_GPU()                                                       \
  if (const ::drape::CudaSurvey survey = ::drape::SurveyCuda(); !survey.usable) \
  GTEST_SKIP() << "needs a GPU: " << survey.text

namespace drape::test {

// ‖a − b‖ / ‖b‖; NaN counts as infinitely far.
template <class A, class B>
double RelativeError(const A& a, const B& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return 1e300;
  const double error = (a - b).norm() / (b.norm() > 0.0 ? b.norm() : 1.0);
  return error == error ? error : 1e300;
}

}  // namespace drape::test
