// SPDX-License-Identifier: Apache-2.0
#include "solver/prediction/exchange/round_trip.h"

#include <glog/logging.h>

namespace drape {

RoundTrip CompareRoundTrip(const std::vector<DrapeSample>& original,
                           const std::vector<DrapeSample>& exported) {
  CHECK_EQ(original.size(), exported.size());
  RoundTrip trip;
  trip.starts = static_cast<int>(original.size());
  for (size_t i = 0; i < original.size(); ++i) {
    const DrapeSample &a = original[i], &b = exported[i];
    if (!a.at_rest || !a.stable || !b.at_rest || !b.stable) continue;
    ++trip.pairs;
    trip.dc_original += a.signature.drape_coefficient;
    trip.dc_exported += b.signature.drape_coefficient;
    trip.nodes_original += a.signature.folds;
    trip.nodes_exported += b.signature.folds;
  }
  if (trip.pairs == 0) return trip;
  for (double* sum :
       {&trip.dc_original, &trip.dc_exported, &trip.nodes_original, &trip.nodes_exported})
    *sum /= trip.pairs;
  return trip;
}

}  // namespace drape
