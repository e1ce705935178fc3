// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "physics/simulation/rollout.h"

namespace drape {

// The stiffness of the simulator against textbooks: closed forms and published figures
// [MODEL, M53–M59], each on the built-in meshes at three resolutions.
struct ReferenceCase {
  std::string name;  // what is measured, with its unit
  double expected = 0.0;
  double tolerance = 0.0;             // of Error() at the finest mesh
  double scale = 0.0;                 // Error() = |computed − expected| / scale
  std::vector<double> computed = {};  // coarse to fine, each half as wide as the one before; NaN
                                      // without an equilibrium

  double Error() const { return std::abs(computed.back() - expected) / scale; }
  bool Holds() const { return Error() <= tolerance; }  // false for NaN

  // log2 of the ratio of two successive changes: p of an error h^p. NaN when the changes are
  // rounding (the meshes agree) or do not shrink in one direction.
  double Order() const {
    constexpr double kRounding = 1e-8;
    const std::size_t n = computed.size();
    const double coarse = computed[n - 2] - computed[n - 3];
    const double fine = computed[n - 1] - computed[n - 2];
    if (!(std::abs(fine) > kRounding * scale) || !(coarse / fine > 0.0))
      return std::numeric_limits<double>::quiet_NaN();
    return std::log2(coarse / fine);
  }
};

// A reference case whose error is relative to its value.
inline ReferenceCase RelativeReference(std::string name, double expected, double tolerance) {
  return {std::move(name), expected, tolerance, std::abs(expected)};
}

inline constexpr double kReferenceGravity = 9.81;  // [m/s²]

// The rigidity D that a mesh makes of a bend table B = 4·D, on discs and strips.
std::vector<ReferenceCase> RigidityCases(const Law& law);
// Drop over reach of a strip under its weight, Γ = ρgL³/EI [Romero 2021], and the 41.5° of
// [ASTM D1388] at Γ = 8.0042.
std::vector<ReferenceCase> CantileverCases(const Law& law);
// The elastica with a load on its tip [Bisshopp 1945], [Mattiasson 1981].
std::vector<ReferenceCase> TipLoadCases(const Law& law);
// ΔL/L = ρgL/2k.
std::vector<ReferenceCase> HangingCases(const Law& law);
// N = k(l² − 1)l/2.
std::vector<ReferenceCase> UniaxialCases(const Law& law);
// A clamped plate, w0 = q·a⁴/(64·D) [Timoshenko 1959].
std::vector<ReferenceCase> ClampedDiscCases(const Law& law);
// The drape test of a stiff cloth, clamped at .6 and .4 of its radius.
std::vector<ReferenceCase> AnnulusCases(const Law& law);
// Rigid motions cause no net force or torque.
std::vector<ReferenceCase> RigidMotionCases(const Law& law);
// A quarter turn of the material exchanges c11 and c22.
std::vector<ReferenceCase> TurnCases(const Law& law);

// Moves x to the equilibrium near it; fills it with NaN when there is none.
void GoToRest(StepSolver& solver, const MaterialField& material, Eigen::VectorXd& x);

}  // namespace drape
