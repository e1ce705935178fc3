// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "physics/mesh/mesh.h"

namespace drape {

// A flat rectangular strip, u in [0, length], v in [−width/2, width/2] [m], z = 0, uv = xy, for
// cantilever, hanging and uniaxial tests. Rows of vertices run along u, each second row shifted by
// half a spacing (half triangles at both ends), so that no diagonal is preferred. With
// n_across ≈ 1.155·n_along·width/length the triangles are equilateral: the one pattern on which the
// hinge formula is isotropic and B = 4·D holds exactly inside the strip.
// The free edges bear no hinges: a strip bent along u has D·(1 − 1/(9·n_across) − 0.648/n_along)
// a width (mesh_rigidity_test). A narrow strip is free to curl across, so it has D·(1 − ν²) with
// the Poisson ratio ν = −1/3 of the hinge formula.
// CHECKs that all arguments are positive.
Mesh MakeStrip(double length, double width, int n_along, int n_across);

// The mesh turned by `place` about z, moved to begin at x = 0 and to lie evenly about y = 0, of a
// cloth whose weft points `direction` clockwise of x, so that a strip along x is cut at `direction`
// to the weft [rad].
Mesh Laid(const Mesh& mesh, double place, double direction);

}  // namespace drape
