// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// A flat rectangular strip, u in [0, length], v in [−width/2, width/2] [m], z = 0, uv = xy, for
// cantilever, hanging and uniaxial tests [MODEL, M3]. Rows of vertices run along u, and every
// second row is shifted by half a spacing (half triangles at both ends), so that no diagonal is
// preferred. With n_across ≈ 1.155·n_along·width/length the triangles are equilateral, the only
// pattern on which the hinge formula is isotropic and B = 4·D holds exactly inside the strip.
//
// The free edges have no hinges, so that a strip held flat across has D·(1 − 1/(9·n_across) −
// 0.648/n_along) by width [MODEL, M54]. A narrow strip is free to curl across and has D·(1 − ν²)
// with the Poisson ratio ν = −1/3 of the hinge formula. CHECKs that all arguments are positive.
Mesh MakeStrip(double length, double width, int n_along, int n_across);

// Turns the mesh by `place` [rad] about z and moves it so that it begins at x = 0 and is centred
// about y = 0. The weft of the cloth then points `direction` [rad] clockwise of x, so that a strip
// along x is cut at `direction` to the weft.
Mesh Laid(const Mesh& mesh, double place, double direction);

// Makes the mesh that a user names: "disc:N" (a built-in disc of N vertices, of the radii `discs`),
// "disc:N,radius=0.15,support=0.09" (either option or both, in metres), "strip:LENGTHxWIDTHxALONG"
// (a strip along x = weft, length and width in metres, ALONG edges along its length and as many
// across as make its triangles equilateral), or the path of an OBJ file. Throws InputError for a
// malformed spec, naming the wrong part and what is expected there, and whatever MakeDisc and
// ReadObj throw.
Mesh ParseMeshSpec(const std::string& spec, const ObjOptions& options = {},
                   const DrapeDiscs& discs = {});

}  // namespace drape
