// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace drape {

// Stiffness as textile laboratories report it: the standards' own formulas, in SI units unless the
// name of a function says otherwise.

// The geometric mean of warp and weft, for rigidities and bending lengths.
double OverallStiffness(double warp, double weft);

// The forces of FAST's extensions E5, E20 and E100 (5, 20 and 100 gf/cm) and of the KES-FB
// extension EMT (500 gf/cm) [N/m].
inline constexpr double kFastForces[] = {4.903325, 19.6133, 98.0665};
inline constexpr double kKesForce = 490.3325;
// The largest extensions that the instruments read [%], nominally: their jaws go no further apart.
// A computed extension beyond them is none that a laboratory could report.
inline constexpr double kFastMostExtension = 20.0, kKesMostExtension = 100.0;
// The extension [%] of a strip of stiffness Y [N/m] under a force [N/m], taken as linear.
double ExtensionPercent(double force, double stiffness);
// FAST's shear rigidity G [N/m] = 123/EB5 of the bias extension EB5 [%], and back.
double FastBiasExtensionPercent(double shear_rigidity);
// FAST's formability F [mm²] = B [µN·m]·(E20 − E5) [%]/14.7.
double FormabilityMm2(double rigidity, double e5_percent, double e20_percent);

// KES-FB: B [gf·cm²/cm] of a rigidity [N·m], and G [gf/(cm·°)] of a shear rigidity [N/m].
double KesBending(double rigidity);
double KesShear(double shear_rigidity);

}  // namespace drape
