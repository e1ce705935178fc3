// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace drape {

// Which numbers of a fit can be trusted: fits of drapes of known fabrics, the fitted over the known
// value of each (ListStiffness).

struct RecoveredQuantity {
  std::string name;                 // for a person
  std::vector<double> ratios = {};  // fitted/reference of each fit, ascending
  double claimed_factor = 0.0;      // median of the fits' 90 % factors; 0: fits claim none

  // By linear interpolation; share: 0 … 1.
  double Quantile(double share) const;
};

struct Recovery {
  std::vector<RecoveredQuantity> quantities;  // in the order of ListStiffness
  int fits = 0;
  int left_out = 0;  // of fits that are judged "do not use"
};

// folders: of drape_fit with --ground_truth. Throws InputError for a summary.json that is missing
// or without references, and where no fit is left.
Recovery ReadRecovery(const std::vector<std::string>& folders);

std::string RecoveryText(const Recovery& recovery);
// A row for each quantity: every fit as a dot, the range of 90 % of them as a bar, and the interval
// that the fits claim. Throws InputError.
void RenderRecovery(const Recovery& recovery, const std::string& path);

}  // namespace drape
