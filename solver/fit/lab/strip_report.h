// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "physics/material/material.h"
#include "solver/fit/lab/strip_residuals.h"

namespace drape {

// A measurement beside what the fitted material makes of it.
struct StripReport {
  LabMeasurement measurement;
  std::vector<double> computed;  // of each point, as LabPoint::reading
  double density = 0.0;          // [kg/m²]
};

// What a laboratory derives from a cantilever by hand [ASTM D1388].
struct BendingEstimate {
  double length = 0.0;    // bending length c = L/Γ(angle)^⅓, half the overhang L at 41.5° [m]
  double rigidity = 0.0;  // flexural rigidity G = ρ·g·c³ [N·m]
};
// NaN for an angle [°] that is not between 0 and 90.
BendingEstimate EstimateBending(double overhang, double angle, double density);

// None when a strip cannot be computed.
std::vector<StripReport> ReportStrips(const StripResiduals& strips, const MaterialField& material);

nlohmann::ordered_json StripsJson(const std::vector<StripReport>& reports);
// For a person: one line a point.
std::string StripTable(const std::vector<StripReport>& reports);

}  // namespace drape
