// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>

#include "solver/fit/observed/lab_measurement.h"

namespace drape::test {

// Writes a file that ReadLabMeasurements reads.
inline void WriteLabMeasurement(const std::string& path, const LabMeasurement& measurement) {
  const bool tensile = measurement.kind == LabMeasurementKind::kTensile;
  nlohmann::json document = {{"test", ToString(measurement.kind)},
                             {"direction", measurement.direction},
                             {"sigma", measurement.sigma}};
  if (tensile) document["length"] = measurement.length;
  if (measurement.width > 0.0) document["width"] = measurement.width;
  for (const LabPoint& point : measurement.points)
    document["points"].push_back({{tensile ? "force" : "length", point.set},
                                  {tensile ? "stretch" : "angle", point.reading}});
  std::ofstream(path) << document;
}

}  // namespace drape::test
