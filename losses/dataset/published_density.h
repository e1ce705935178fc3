// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

namespace drape {

// Areal density [kg/m²] of a fabric of the public data set, as published with it [Gong 2024],
// fabrics 1–25; none for another number.
std::optional<double> PublishedDensity(int fabric);

}  // namespace drape
