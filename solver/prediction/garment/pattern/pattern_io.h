// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "solver/prediction/garment/pattern/pattern.h"

namespace drape {

// Reads a pattern of our own format ("drapefit-garment", configs/README.md) or a specification of
// GarmentCode [Korosteleva 2023], which has a key "pattern". Of that: straight, quadratic, cubic
// and circular edges, curvature as two numbers of older files, seams of the third entry
// "right_wrong", lengths by "units_in_meter", y up and facing +z, which are turned to z up and
// facing −y. Labels and parameters are skipped. A panel whose outline is clockwise is turned over,
// so that edges keep their numbers.
//
// Throws InputError "file: key 'panels.front.outline[2]': found …, expected …" for a missing or
// unknown key (of our own format), a number out of range, an outline that is not closed, a seam of
// a panel or edge that there is not, and whatever FindProblem finds.
Pattern ReadPattern(const std::string& path);

}  // namespace drape
