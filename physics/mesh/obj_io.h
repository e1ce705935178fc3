// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "physics/mesh/mesh.h"

namespace drape {

struct ObjOptions {
  // Round v and vt to float32, then widen, as the reference law does [MODEL, M1].
  bool round_to_float = false;
  // The file's first vt line is a filler: vt index k means line k + 1 (published drape meshes).
  bool first_vt_is_dummy = false;
};

// Vertices and triangles of an OBJ file, without a material space: what a target mesh has.
struct ObjSurface {
  Eigen::VectorXd x;  // [m], shape [3V]
  std::vector<std::array<int, 3>> triangles;
};

// Reads a strict subset of OBJ: v (3 numbers), vt (2 or 3), vn (3), f (3 corners a, a/b, a//c or
// a/b/c; negative = counted from the last), comments, CRLF; o g s usemtl mtllib are skipped.
// Throws InputError("path:line", …) for all else: a missing or extra field, a face that is no
// triangle, an index out of range, a number that is not finite.
ObjSurface ReadObjSurface(const std::string& path, const ObjOptions& options = {});

// Reads a cloth. Material coordinates [m] are the vt when each vertex has exactly one vt value,
// else xy when all z are equal. A mesh that is clockwise throughout in them is turned over.
// Throws as ReadObjSurface and BuildMesh do, and when there are no material coordinates, the faces
// are partly clockwise, or the vt are not in metres (mean edge over twice or under half that of v).
Mesh ReadObj(const std::string& path, const ObjOptions& options = {});

// Writes positions x [m], shape [3V], with the mesh's faces and with vt = uv; atomic. Numbers read
// back bit for bit. Throws InputError when the file cannot be written.
void WriteObj(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x);

}  // namespace drape
