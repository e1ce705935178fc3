// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// configs/accuracy.json as of the build, so that programs have it wherever they are put.
extern const char* const kBuiltInAccuracy;

}  // namespace drape
