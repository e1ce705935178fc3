// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "physics/mesh/disc.h"
#include "physics/mesh/mesh.h"

namespace drape {

// The unprocessed content of an OBJ file, for obj_io. Indices count from 0; -1 means absent.
struct ObjCorner {
  int v, vt, vn;
};

struct ObjFace {
  ObjCorner corner[3];
  int line;  // from 1
};

struct ObjContent {
  std::vector<Eigen::Vector3d> v;
  std::vector<Eigen::Vector2d> vt;
  int num_vn = 0;
  std::vector<ObjFace> faces;     // polygons as triangles
  std::set<std::string> skipped;  // keywords that are not of OBJ, in quotes: the first few
};

// Cuts a polygon into triangles of its corners, by their numbers, from the corner that gives the
// largest smallest triangle. Throws InputError (prefix `where`) where no corner of more than
// four sees all others, and for more than 1000.
std::vector<std::array<int, 3>> SplitPolygon(const std::vector<Eigen::Vector3d>& corners,
                                             const std::string& where);

// Parses the subset of OBJ that obj_io.h describes. `path` is used in messages only. Throws
// InputError("path:line", …).
ObjContent ParseObj(std::string_view text, const std::string& path, bool round_to_float);

struct ObjOptions {
  // Round v and vt to float32, then widen, as the reference law does [MODEL, M1].
  bool round_to_float = false;
  // Ignore the first vt line of the file: vt index k means line k + 1 (published drape meshes).
  bool first_vt_is_dummy = false;
};

// Vertices and triangles of an OBJ file without material coordinates, as a reconstructed drape has
// them.
struct ObjSurface {
  Eigen::VectorXd x;  // [m], shape [3V]
  std::vector<std::array<int, 3>> triangles;
};

// Reads the triangles of an OBJ file: v (x y z, a w of 1 or a colour), vt (2 or 3 numbers), vn (3),
// f (3 or more corners a, a/b, a//c or a/b/c; a negative index counts from the last entry; polygons
// by SplitPolygon), comments, a byte order mark, CRLF, lines that a backslash continues. Other
// keywords of OBJ are skipped, unknown ones with a note (NoteInput). Throws InputError("path:line",
// …) for a missing or extra field, an index out of range, a number that is not finite.
ObjSurface ReadObjSurface(const std::string& path, const ObjOptions& options = {});

// Along x, y and z [m].
Eigen::Vector3d Extents(const ObjSurface& surface);

// What bounds a solid: every edge is of two faces, which traverse it in opposite directions. Throws
// InputError that names `where`, the face and the edge.
void RequireClosed(const ObjSurface& surface, const std::string& where);
// Requires a closed surface whose faces are counter-clockwise seen from outside and which does not
// intersect itself (FindSelfIntersections). Throws InputError that names `where`.
void RequireSolid(const ObjSurface& surface, const std::string& where);

// Reads a cloth [MODEL, M1]. Its material coordinates [m] are the vt when each vertex has exactly
// one vt value, otherwise x and y when all z are equal; also, with a note, when the vt are not in
// metres: their mean edge is more than twice or less than half that of v, or, of vt from 0 to 1,
// differs by more than a tenth. A mesh that is clockwise throughout in these coordinates is turned
// over. Throws InputError as ReadObjSurface and BuildMesh do, when there are no material
// coordinates, when only some faces are clockwise, and for an extent that CheckUsual refuses.
Mesh ReadObj(const std::string& path, const ObjOptions& options = {});

// Writes positions x [m], shape [3V], with the faces of the mesh and with vt = uv. The write is
// atomic, and numbers read back bit for bit. A comment says of which discs the drape is, where they
// are given. CHECKs the size of x. Throws InputError when the file cannot be written.
void WriteObj(const std::string& path, const Mesh& mesh, const Eigen::VectorXd& x,
              const std::optional<DrapeDiscs>& discs = {});
// Writes a surface, which has no vt.
void WriteObj(const std::string& path, const ObjSurface& surface);

// What that comment says; none in a file of others. Throws InputError for a file that cannot be
// read.
std::optional<DrapeDiscs> ReadObjDiscs(const std::string& path);

}  // namespace drape
