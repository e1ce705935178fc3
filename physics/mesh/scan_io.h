// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "physics/mesh/obj_io.h"

namespace drape {

// The extension of a path in lower case, ".stl".
std::string LowerExtension(const std::string& path);

// Returns whether a name ends like that of a file of ReadSurface: .obj, .stl, .ply, in any case.
bool IsSurfaceFile(const std::string& path);

// Reads a surface of a scanner or of another program, by the end of its name. Not by what a file
// claims of its size but by what it holds is memory taken.
//   .stl: binary or text. Corners at the same place are one vertex; triangles without area between
//     three places are left out.
//   .ply: text, or binary of either byte order: x, y, z of "vertex", and the list vertex_indices or
//     vertex_index of "face" (SplitPolygon). Other elements and properties are skipped.
//   others: OBJ (ReadObjSurface).
// Throws InputError that names the file and the line or element: for a file that ends early, an
// unknown format, a number that is not finite, an index out of range, and no faces.
ObjSurface ReadSurface(const std::string& path);

// Reads the vertices alone of such a file, which needs no faces then: a cloud of points [m], shape
// [3N]. Throws InputError as ReadSurface does, and for no vertices.
Eigen::VectorXd ReadVertices(const std::string& path);

}  // namespace drape
