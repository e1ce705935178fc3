// SPDX-License-Identifier: Apache-2.0
// IsUsable for optimiser_nlopt.cc in a build without NLopt.
#include <glog/logging.h>

#include "solver/studies/optimisers/methods/optimiser_methods.h"

namespace drape {

bool NLoptIsThere() { return false; }

std::string RunNLopt(BudgetedFunction&, const std::string& name, const OptimiserOptions&) {
  LOG(FATAL) << name << " is one of NLopt, which this build is without";
  return {};
}

}  // namespace drape
