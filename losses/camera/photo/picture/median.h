// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <vector>

// Internal to losses/camera/photo.
namespace drape {

// The upper median; 0 of no values.
template <typename T>
T Median(std::vector<T> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace drape
