// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "solver/forward/random_drapes.h"

namespace drape {

// How drapes change when a fabric is replaced by what another program takes of it: both draped here
// from the same random starts.
struct RoundTrip {
  int starts = 0;  // of each fabric
  int pairs = 0;   // with a stable drape of both
  // Means over the pairs.
  double dc_original = 0.0, dc_exported = 0.0;        // drape coefficient, 0 … 1
  double nodes_original = 0.0, nodes_exported = 0.0;  // number of folds
};

// Of drapes of SampleEquilibria with the same options.
RoundTrip CompareRoundTrip(const std::vector<DrapeSample>& original,
                           const std::vector<DrapeSample>& exported);

}  // namespace drape
