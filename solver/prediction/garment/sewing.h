// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "physics/cloth/cloth_model.h"
#include "solver/prediction/garment/garment_mesh.h"

namespace drape {

// A garment as one cloth under gravity, ready to be worn: the vertices that a stitch joins are one.
struct SewnGarment {
  // Faces and hinges are those of the panels in their rest state. The panels do not fit together
  // flat, so mesh.rest_x is the start, and there are no boundary loops.
  std::shared_ptr<const ClothModel> model = {};
  Eigen::VectorXd start_x = {};          // shape [3V]: joined vertices begin in the middle [m]
  std::vector<int> vertex_of;            // of each vertex of the GarmentMesh
  std::vector<int> held_by_pelvis = {};  // vertices of its rings, ascending
};

SewnGarment Sew(const GarmentMesh& garment, const Law& law);

}  // namespace drape
