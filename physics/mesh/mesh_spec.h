// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// Makes the mesh that a user names: "disc:N" (a built-in disc of N vertices, of the radii `discs`),
// "disc:N,radius=0.15,support=0.09" (either option or both, in metres), "strip:LENGTHxWIDTHxALONG"
// (a strip along x = weft, length and width in metres, ALONG edges along its length and as many
// across as make its triangles equilateral), or the path of an OBJ file. Throws InputError for a
// malformed spec, naming the wrong part and what is expected there, and whatever MakeDisc and
// ReadObj throw.
Mesh ParseMeshSpec(const std::string& spec, const ObjOptions& options = {},
                   const DrapeDiscs& discs = {});

}  // namespace drape
