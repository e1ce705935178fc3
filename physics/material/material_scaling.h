// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/material/material.h"

namespace drape {

// `material` with all stretch entries times stretch, all bend entries times bend.
MaterialField Scaled(MaterialField material, double stretch, double bend);

// Whether each stretch table resists all strains: c11, c22, c33 > 0 and c12² < c11·c22 in all rows
// (so between them too). A cloth without that has no energy minimum under compression, and its time
// step no positive definite matrix.
bool ResistsAllStrains(const MaterialField& material);

// Simpler forms of tables.
enum class TableForm {
  kGiven,
  kLinear,    // stiffness does not follow from strain or curvature: each column of stretch and each
              // row of bend has its mean
  kIsotropic  // and nor from direction: c22 = c11, c33 = c11 − c12 (mean of c11 and c22), one bend
              // entry; what is left of c12 is the Poisson ratio c12/c11, below 1
};
// "given", "linear" or "isotropic". Throws InputError for any other.
TableForm ParseTableForm(const std::string& text);
const char* ToString(TableForm form);
MaterialField InForm(MaterialField material, TableForm form);

// Membrane stiffness along the threads, the mean over rows of c11 and c22 [N/m]; plate rigidity,
// the mean over the table [N m].
double MeanStretch(const StretchTable& table);
double MeanBend(const BendTable& table);

// One table of the arithmetic means over the elements.
MaterialField MeanTables(const MaterialField& field);

}  // namespace drape
