// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "solver/prediction/exchange/exchange_record.h"

namespace drape::test {

// A fabric whose numbers all differ.
inline constexpr LinearFabric kTwill = {.c11 = 300.0,
                                        .c22 = 220.0,
                                        .c12 = 40.0,
                                        .shear = 12.0,
                                        .bend_weft = 2e-5,
                                        .bend_warp = 9e-6,
                                        .bend_bias = 1.1e-5,
                                        .density = 0.21};

}  // namespace drape::test
