// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// configs/fabrics/synthetic_shirt.json as of the build.
extern const char* const kBuiltInFabric;

}  // namespace drape
