// SPDX-License-Identifier: Apache-2.0
#include "physics/material/laboratory_stiffness.h"

#include <cmath>

#include "physics/material/material_scaling.h"

namespace drape {
namespace {

constexpr double kMicro = 1e-6, kPercent = 100.0;
constexpr double kFastShear = 123.0, kFastFormability = 14.7;
constexpr double kGramForce = 1e-3 * kStandardGravity;  // [N]
constexpr double kCentimetre = 1e-2;

}  // namespace

double OverallStiffness(double warp, double weft) { return std::sqrt(warp * weft); }

double ExtensionPercent(double force, double stiffness) { return kPercent * force / stiffness; }

double FastBiasExtensionPercent(double shear_rigidity) { return kFastShear / shear_rigidity; }

double FormabilityMm2(double rigidity, double e5_percent, double e20_percent) {
  return rigidity / kMicro * (e20_percent - e5_percent) / kFastFormability;
}

double KesBending(double rigidity) { return rigidity / (kGramForce * kCentimetre); }

double KesShear(double shear_rigidity) {
  return shear_rigidity / (kGramForce / kCentimetre) * M_PI / 180.0;
}

}  // namespace drape
