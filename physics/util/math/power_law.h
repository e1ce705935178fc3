// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

namespace drape {

// y = factor·x^exponent by least squares of the logarithms.
struct PowerLaw {
  double exponent = 0.0;
  double factor = 0.0;
};
// Empty for fewer than two distinct x. CHECKs that all are positive.
std::optional<PowerLaw> FitPowerLaw(std::span<const double> x, std::span<const double> y);

}  // namespace drape
