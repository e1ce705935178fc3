// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/tables/outline_list.h"

#include <glog/logging.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"

namespace drape {
namespace {

constexpr int kListedAngles = 120;
constexpr double kStepsPerMetre = 1e5;

nlohmann::ordered_json OutlineJson(const ListedOutline& outline) {
  CHECK_EQ(outline.radius.size() % kListedAngles, 0) << outline.name;
  const Eigen::Index step = outline.radius.size() / kListedAngles;
  std::vector<double> radius;
  for (Eigen::Index k = 0; k < outline.radius.size(); k += step)
    radius.push_back(std::round(outline.radius[k] * kStepsPerMetre) / kStepsPerMetre);
  return {{"name", outline.name},
          {"group", outline.group},
          {"dc", outline.drape_coefficient},
          {"folds", outline.folds},
          {"radius_m", radius}};
}

}  // namespace

void WriteOutlines(const std::string& path, const std::vector<ListedOutline>& outlines) {
  std::string text = "{\"format\": \"drapefit-outlines\", \"version\": 1,\n \"drapes\": [";
  for (std::size_t i = 0; i < outlines.size(); ++i)
    text += (i == 0 ? "\n  " : ",\n  ") + OutlineJson(outlines[i]).dump();
  WriteFileAtomically(path, text + "]}\n");
}

}  // namespace drape
