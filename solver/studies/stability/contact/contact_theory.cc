// SPDX-License-Identifier: Apache-2.0
#include "solver/studies/stability/contact/contact_theory.h"

#include <functional>
#include <string>
#include <utility>

#include "solver/studies/stability/contact/contact_scene.h"

namespace drape {
namespace {

// The line where the axis of this name has the value that theory gives for a case.
StabilityLine MakeLine(const StabilityMap& map, const std::string& name, std::string title,
                       const std::function<double(const StabilityCase&)>& limit) {
  StabilityLine line{.title = std::move(title), .x = {}, .y = {}};
  for (const int k : {0, 1}) {
    if (map.axis[k]->name != name) continue;
    const std::vector<double>&along = map.values[1 - k], &across = map.values[k];
    for (int i = 0; i < static_cast<int>(along.size()); ++i) {
      const double value = limit(k == 0 ? map.At(0, i) : map.At(i, 0));
      if (value < across.front() || value > across.back()) continue;
      (k == 0 ? line.x : line.y).push_back(value);
      (k == 0 ? line.y : line.x).push_back(along[i]);
    }
  }
  return line;
}

}  // namespace

StabilityLine MakeContactLine(const StabilityMap& map) {
  switch (map.base.scenario) {
    case StabilityScenario::kPlate:
      if (map.base.method == StabilityMethod::kPenalty)
        return MakeLine(map, "speed", "v h = thickness of the plate",
                        [](const StabilityCase& run) { return kPlateThickness / run.h; });
      return {};
    case StabilityScenario::kRod:
      return MakeLine(map, "radius", "ℓ² = 4 R ξ", [](const StabilityCase& run) {
        return run.edge * run.edge / (4.0 * run.thickness);
      });
    case StabilityScenario::kSlope:
      return MakeLine(map, "friction", "μ = tan θ",
                      [](const StabilityCase&) { return kSlopeTangent; });
    case StabilityScenario::kPinch:
      return MakeLine(map, "distance", "thickness of the layers",
                      [](const StabilityCase& run) { return run.layers * run.thickness; });
    default:
      return {};
  }
}

}  // namespace drape
