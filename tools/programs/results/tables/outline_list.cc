// SPDX-License-Identifier: Apache-2.0
#include "tools/programs/results/tables/outline_list.h"

#include <glog/logging.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "physics/util/atomic_file.h"
#include "physics/util/json_input.h"

namespace drape {
namespace {

constexpr char kOutlinesFormat[] = "drapefit-outlines";
constexpr int kVersion = 1;
constexpr double kStepsPerMetre = 1e5;
constexpr int kMost = 1'000'000;  // groups, folds

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
  std::string text = "{\"format\": \"" + std::string(kOutlinesFormat) +
                     "\", \"version\": " + std::to_string(kVersion) + ",\n \"drapes\": [";
  for (std::size_t i = 0; i < outlines.size(); ++i)
    text += (i == 0 ? "\n  " : ",\n  ") + OutlineJson(outlines[i]).dump();
  WriteFileAtomically(path, text + "]}\n");
}

std::vector<ListedOutline> ReadOutlines(const std::string& path) {
  const nlohmann::json file = ReadJsonFile(path);
  const JsonInput input(file, path);
  if (!input.Has("format") || input.At("format").value() != kOutlinesFormat)
    input.Fail(std::string("outlines of drapes, with \"format\": \"") + kOutlinesFormat + '"');
  if (input.At("version").Integer() != kVersion) input.At("version").Fail(std::to_string(kVersion));
  const JsonInput drapes = input.At("drapes");
  drapes.ExpectArray();
  std::vector<ListedOutline> outlines;
  for (int i = 0; i < drapes.Size(); ++i) {
    const JsonInput drape = drapes.At(i), radius = drape.At("radius_m");
    outlines.push_back({drape.At("name").String(), drape.At("group").IntegerWithin(0, kMost),
                        drape.At("dc").Number(), drape.At("folds").IntegerWithin(0, kMost),
                        radius.Vector(kListedAngles)});
    if (outlines.back().radius.minCoeff() < 0.0) radius.Fail("radii of at least 0");
  }
  return outlines;
}

}  // namespace drape
