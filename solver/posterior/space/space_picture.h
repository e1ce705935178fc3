// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "solver/posterior/space/material_space.h"

namespace drape {

// Pictures of a space of materials, each a PNG. All throw InputError without gnuplot.

// Hellinger metric of all pairs as colours, in the order of the tree, with the tree beside it.
void RenderHeatMap(const std::string& path, const MaterialSpace& space);
// Fabrics in the plane of least distortion of their Wasserstein metric, with ellipses of one
// standard deviation; further materials as diamonds.
void RenderSpaceMap(const std::string& path, const MaterialSpace& space);
// Bending lengths along weft and warp [cm] with ellipses of one standard deviation, and curves of
// equal drape coefficient of an isotropic cloth with their geometric mean.
void RenderTextileMap(const std::string& path, const MaterialSpace& space,
                      const std::vector<FabricBelief>& added);

// The drape coefficient of an isotropic linear cloth on the support of [BS 5058] by its bending
// length [m], as drape_equilibria computes it [METHODS, P62]; interpolated.
double IsotropicDrapeCoefficient(double bending_length);
// The inverse, for coefficients from 0 to 0.98 [m].
double IsotropicBendingLength(double drape_coefficient);

}  // namespace drape
