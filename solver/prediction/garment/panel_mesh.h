// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "solver/prediction/garment/pattern/pattern.h"

namespace drape {

struct PanelMesh {
  Eigen::Matrix2Xd points;                    // [m], shape [2, V]
  std::vector<std::array<int, 3>> triangles;  // counter-clockwise
  std::vector<std::vector<int>> edges;        // the vertices of each edge, both ends included
};

// One panel with segments[e] equal segments on edge e and triangle edges of about `edge` [m]
// inside. Throws InputError that names `where` and the panel when they are too long for it.
PanelMesh MakePanelMesh(const Panel& panel, const std::vector<int>& segments, double edge,
                        const std::string& where);

}  // namespace drape
