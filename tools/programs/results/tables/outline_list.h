// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace drape {

// The outlines of the drapes of a run, which a page shows side by side: outlines.json,
//   {"format": "drapefit-outlines", "version": 1,
//    "drapes": [{"name", "group", "dc", "folds", "radius_m" [kListedAngles]}]}.
struct ListedOutline {
  std::string name;  // "specimen 3, face up"
  int group = 0;     // of drapes of one specimen or of one branch, from 0
  double drape_coefficient = 0.0;
  int folds = 0;
  Eigen::VectorXd radius;  // [m] at equal angles, counter-clockwise from the right as seen
};

inline constexpr char kOutlinesFile[] = "outlines.json";
inline constexpr int kListedAngles = 120;

// Of a finer outline, such as one of 360 radii; in steps of 10 µm. CHECKs that its number of radii
// is a multiple of kListedAngles. Throws InputError when the file cannot be written.
void WriteOutlines(const std::string& path, const std::vector<ListedOutline>& outlines);

// Throws InputError naming the file and the key for another format, and for a radius below 0.
std::vector<ListedOutline> ReadOutlines(const std::string& path);

}  // namespace drape
