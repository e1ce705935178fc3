// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/material.h"
#include "physics/util/options/field.h"

namespace drape {

// Returns `material` with all stretch entries multiplied by `stretch` and all bend entries by
// `bend`.
MaterialField Scaled(MaterialField material, double stretch, double bend);

// Raises each entry that is below `share` times the largest of its column (stretch) or row (bend)
// to that, in all tables; returns how many it raised.
int RaiseSmallEntries(MaterialField& field, double share);

// Simpler forms of the tables.
enum class TableForm {
  kGiven,
  kLinear,    // stiffness independent of strain and curvature: each column of stretch and each
              // row of bend is replaced by its mean
  kIsotropic  // also independent of direction: c22 = c11 = their mean, c33 = c11 − c12, one bend
              // entry; the Poisson ratio c12/c11 remains, below 1
};
constexpr auto EnumNames(TableForm) {
  return MakeNames<TableForm>({{TableForm::kGiven, "given"},
                               {TableForm::kLinear, "linear"},
                               {TableForm::kIsotropic, "isotropic"}});
}
// Returns `material` with its tables reduced to that form.
MaterialField InForm(MaterialField material, TableForm form);

// The membrane stiffness along the threads, which is the mean over all rows of c11 and c22 [N/m],
// and the plate rigidity, which is the mean over the table [N·m] [MODEL, M7, M8].
double MeanStretch(const StretchTable& table);
double MeanBend(const BendTable& table);

inline constexpr double kStandardGravity = 9.80665;  // [m/s²]

// A rigidity over the weight by area, D/(ρg) [m³], and its cube root, the bending length [m] [ASTM
// D1388]: what a drape shows of a cloth whose weight is not known. density [kg/m²]; standard
// gravity.
double BendOverWeight(double rigidity, double density);
double BendingLength(double rigidity, double density);

// Returns one table of each kind with the arithmetic means over the elements.
MaterialField MeanTables(const MaterialField& field);

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
