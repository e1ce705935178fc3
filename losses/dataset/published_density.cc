// SPDX-License-Identifier: Apache-2.0
#include "losses/dataset/published_density.h"

#include <array>

namespace drape {

std::optional<double> PublishedDensity(int fabric) {
  static constexpr std::array kDensities = {.059, .192, .213, .114, .274, .183, .100, .230, .249,
                                            .204, .148, .313, .107, .139, .211, .191, .278, .154,
                                            .282, .259, .186, .231, .163, .104, .060};
  if (fabric < 1 || fabric > static_cast<int>(kDensities.size())) return {};
  return kDensities[fabric - 1];
}

}  // namespace drape
