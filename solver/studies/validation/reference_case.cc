// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/validation/reference_case.h"

#include <cmath>
#include <limits>

namespace drape {

double ReferenceCase::Error() const { return std::abs(computed.back() - expected) / scale; }

bool ReferenceCase::Holds() const { return Error() <= tolerance; }

double ReferenceCase::Order() const {
  constexpr double kRounding = 1e-8;
  const std::size_t n = computed.size();
  if (n < 3) return std::numeric_limits<double>::quiet_NaN();
  const double coarse = computed[n - 2] - computed[n - 3], fine = computed[n - 1] - computed[n - 2];
  if (!(std::abs(fine) > kRounding * scale) || !(coarse / fine > 0.0))
    return std::numeric_limits<double>::quiet_NaN();
  return std::log2(coarse / fine);
}

}  // namespace drape
