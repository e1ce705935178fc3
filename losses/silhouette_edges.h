// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/mesh.h"

namespace drape {

// Point where the projections of the mesh edges a→b and c→d cross.
struct EdgeCrossing {
  int vertex[4];  // a, b, c, d
  double t[2];    // position on a→b and on c→d, in (0, 1)
};

// Part of a projected mesh edge that borders the union of all projected triangles.
struct SilhouettePiece {
  int vertex[2];           // the edge a→b
  double t[2];             // the piece runs from a + t[0](b−a) to a + t[1](b−a)
  int crossing[2];         // index of the crossing that ends it, or −1: it ends at a vertex
  Eigen::Vector2d inward;  // unit normal towards the cloth
};

struct SilhouetteEdges {
  std::vector<SilhouettePiece> pieces;
  std::vector<EdgeCrossing> crossings;
};

// The border of the silhouette (holes included). Candidates are the boundary edges of the mesh and
// the hinges whose faces fold over one another in the image; they are cut where they cross, and a
// part stays when exactly one of its sides is covered. image_points: finite, [px], shape [2, V].
SilhouetteEdges FindSilhouetteEdges(const Mesh& mesh, const Eigen::Matrix2Xd& image_points);

}  // namespace drape
