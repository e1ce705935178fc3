// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/mesh/mesh.h"
#include "physics/mesh/obj_io.h"

namespace drape {

// The mesh that a user names: "disc:N" (a built-in disc of N vertices),
// "disc:N,radius=0.15,support=0.09" (any of the two, in metres), "strip:LENGTHxWIDTHxALONG" (a
// strip along x = weft in metres, ALONG edges long, as wide in edges as makes its triangles
// equilateral) or the path of an OBJ file. Throws InputError for a malformed spec (says which part
// and what is expected) and whatever MakeDisc and ReadObj throw.
Mesh ParseMeshSpec(const std::string& spec, const ObjOptions& options = {});

}  // namespace drape
