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

// Finds the border of the silhouette, holes included. The candidates are the boundary edges of the
// mesh and the hinges whose faces overlap in the image. They are cut where they cross, and a part
// is kept when exactly one of its sides is covered. image_points: finite, [px], shape [2, V].
SilhouetteEdges FindSilhouetteEdges(const Mesh& mesh, const Eigen::Matrix2Xd& image_points);

}  // namespace drape
