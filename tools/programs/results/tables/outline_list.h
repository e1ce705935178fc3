// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace drape {

// The outlines of the drapes of a run, which a page shows side by side: outlines.json,
//   {"format": "drapefit-outlines", "version": 1,
//    "drapes": [{"name", "group", "dc", "folds", "radius_m" [120]}]}.
struct ListedOutline {
  std::string name;  // "specimen 3, face up"
  int group = 0;     // of drapes of one specimen or of one branch, from 0
  double drape_coefficient = 0.0;
  int folds = 0;
  Eigen::VectorXd radius;  // [m] at equal angles, counter-clockwise from the right as seen
};

inline constexpr char kOutlinesFile[] = "outlines.json";

// Writes 120 radii of each finer outline, such as one of 360, in steps of 10 µm. CHECKs that the
// number of radii is a multiple of 120. Throws InputError when the file cannot be written.
void WriteOutlines(const std::string& path, const std::vector<ListedOutline>& outlines);

}  // namespace drape
