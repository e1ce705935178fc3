// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "losses/readout/place_readouts.h"
#include "physics/mesh/mesh.h"

namespace drape {

// Measurements as files hold them. All readers throw an InputError that names the file, the line or
// what else is wrong, and what was expected; also for more than 2^24 rows, points or pixels, and
// for an extent in another unit than metres (CheckUsual).
//
// A table is text: a header with the names of the columns, in that order, and a line of numbers for
// each row, separated by commas or semicolons. Between semicolons a comma is a decimal point. A
// byte order mark, CRLF, quotes around a field and blank lines are accepted.

// Places of the cloth and where they were seen. Either `material` or `vertices` is empty.
struct MeasuredMarkers {
  Eigen::Matrix2Xd material;  // (weft, warp) [m], shape [2, N]
  std::vector<int> vertices;  // counted from 0, shape [N]
  Eigen::VectorXd x;          // [m], shape [3N]
};
// Reads a table of weft_m,warp_m,x_m,y_m,z_m or of vertex,x_m,y_m,z_m.
MeasuredMarkers ReadMarkers(const std::string& path);
// The places on a mesh. Throws InputError (prefix `where`) for one that is not on it.
PlaceWeights WeightsOfMarkers(const Mesh& mesh, const MeasuredMarkers& markers,
                              const std::string& where);

// Reads a cloud of points [m], shape [3N], by the end of the name: the vertices of .obj, .stl or
// .ply (ReadVertices); others are a table of x,y,z or x_m,y_m,z_m.
Eigen::VectorXd ReadPointCloud(const std::string& path);

struct DepthMap {
  int width = 0;              // [px]
  int height = 0;             // [px]
  std::vector<double> depth;  // [m], row-major, row 0 at the top; 0: not measured
  std::vector<int> pixels;    // row·width + column where it is measured
};
// Reads a grey PNG of 16 bits as it is stored: without gamma, orientation or colour profile, which
// would change its counts. A count of 0 is no data. metres_per_count: more than 0.
DepthMap ReadDepthMap(const std::string& path, double metres_per_count);

}  // namespace drape
