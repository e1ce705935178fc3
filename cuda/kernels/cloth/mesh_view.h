// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "physics/mesh/mesh.h"

namespace drape {

// A mesh as a camera sees it, whatever acts in its scene: plain data for host and device, vertices
// in the order of the positions.
struct MeshView {
  int num_vertices, num_faces, num_hinges;
  int num_border;  // boundary edges
  int num_hem;     // of them, the first: those of boundary_loops[0] in order
  const Face* faces;
  const Hinge* hinges;
  const int* border;  // [num_border, 2] vertices
};

// Boundary edges of a mesh, loop after loop, shape [num_border, 2].
inline std::vector<int> FindBorder(const Mesh& mesh) {
  std::vector<int> border;
  for (const std::vector<int>& loop : mesh.boundary_loops)
    for (std::size_t i = 0; i < loop.size(); ++i) {
      border.push_back(loop[i]);
      border.push_back(loop[(i + 1) % loop.size()]);
    }
  return border;
}

// Views a mesh whose faces, hinges and border lie there.
inline MeshView MakeView(const Mesh& mesh, const Face* faces, const Hinge* hinges,
                         const int* border) {
  int num_border = 0;
  for (const std::vector<int>& loop : mesh.boundary_loops)
    num_border += static_cast<int>(loop.size());
  const int num_hem =
      mesh.boundary_loops.empty() ? 0 : static_cast<int>(mesh.boundary_loops[0].size());
  return {mesh.num_vertices(),
          mesh.num_faces(),
          mesh.num_hinges(),
          num_border,
          num_hem,
          faces,
          hinges,
          border};
}

}  // namespace drape
