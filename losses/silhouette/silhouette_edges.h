// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "losses/silhouette/silhouette_border.h"
#include "physics/mesh/mesh.h"

namespace drape {

struct SilhouetteEdges {
  std::vector<SilhouettePiece> pieces;
  std::vector<EdgeCrossing> crossings;
};

// The border of the silhouette (holes included). Candidates are the boundary edges of the mesh and
// the hinges whose faces fold over one another in the image; they are cut where they cross, and a
// part stays when exactly one of its sides is covered. image_points: finite, [px], shape [2, V].
SilhouetteEdges FindSilhouetteEdges(const Mesh& mesh, const Eigen::Matrix2Xd& image_points);

}  // namespace drape
