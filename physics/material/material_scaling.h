// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/material/material.h"
#include "physics/util/options/enum_names.h"

namespace drape {

// Returns `material` with all stretch entries multiplied by `stretch` and all bend entries by
// `bend`.
MaterialField Scaled(MaterialField material, double stretch, double bend);

// Raises each entry that is below `share` times the largest of its column (stretch) or row (bend)
// to that, in all tables; returns how many it raised.
int RaiseSmallEntries(MaterialField& field, double share);

// Returns whether each stretch table resists all strains: c11, c22, c33 > 0 and c12² < c11·c22 in
// all rows, and therefore between them too. Without that, a cloth has no energy minimum under
// compression and the matrix of its time step is not positive definite.
bool ResistsAllStrains(const MaterialField& material);

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

}  // namespace drape
