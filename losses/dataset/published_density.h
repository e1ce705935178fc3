// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace drape {

// The areal density [kg/m²] of a fabric of the public data set, as published with it [Gong 2024],
// for fabrics 1–25; std::nullopt for any other number.
std::optional<double> PublishedDensity(int fabric);

}  // namespace drape
