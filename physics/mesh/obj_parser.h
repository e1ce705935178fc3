// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

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
  std::vector<ObjFace> faces;
};

// Parses the subset of OBJ that obj_io.h describes. `path` is used in messages only. Throws
// InputError("path:line", …).
ObjContent ParseObj(std::string_view text, const std::string& path, bool round_to_float);

}  // namespace drape
