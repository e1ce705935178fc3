// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/material/material_io.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Files of a fabric whose tables vary over the cloth. Such a file holds one table for each face and
// each hinge of the mesh on which it was estimated, with the material coordinates of the element:
//   {"format": "drapefit-material-field", "version": 1, "convention": "mechanical", "density",
//    "face_centres" [F][2] (uv in metres), "stretch" [F][24] (rows of [6][4]),
//    "hinge_centres" [E][2], "bend" [E][15] (rows of [3][5]), optional "name", "units", "source"}.

// Writes the file atomically. CHECKs that the field has a table for each face and hinge. Throws
// InputError when the file cannot be written.
void WriteMaterialField(const std::string& path, const Material& material, const Mesh& mesh);

// Reads a file of either kind, of one table (ReadMaterial) or of a field. In the latter case each
// element of `mesh` gets the table of the nearest element in the file, so that the tables come back
// bit for bit on the mesh of the file. Throws InputError as ReadMaterial does.
Material ReadMaterialFor(const Mesh& mesh, const std::string& path,
                         const MaterialPolicy& policy = {});

}  // namespace drape
